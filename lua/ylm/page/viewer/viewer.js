'use strict';
/* The viewer of a page: decodes the grid, makes points of continuity again, draws by WebGL 2, follows the pointer and keys. */
(function () {
  const $ = id => document.getElementById(id);
  const root = document.documentElement;
  const meta = JSON.parse($('meta').textContent);
  const ROW = meta.channels * (meta.lmax + 1) * (meta.lmax + 1), COUNT = (meta.lmax + 1) * (meta.lmax + 1);
  const WIDE = 4096;  /* texels of a row of textures */
  const TONES = ['linear', 'srgb', 'reinhard', 'hable', 'aces'];
  const BUDGET = 80;  /* ms of a frame while something moves */
  const SLICE = 30;   /* ms of work between two looks at the window */

  /* ---- words ------------------------------------------------------------- */

  function fail(message) {
    root.dataset.state = 'failed';
    root.dataset.why = message;
    $('note').textContent = message;
    $('note').className = '';
    $('canvas').style.visibility = 'hidden';
  }
  const say = text => { $('note').textContent = text; };
  /* What is under way before the first picture. */
  const tell = text => say('loading: ' + text + ' ...');
  /* Lets the window do its part; timers would wait 4 ms. */
  const channel = new MessageChannel(), waiting = [];
  channel.port1.onmessage = () => waiting.shift()();
  const breath = () => new Promise(done => { waiting.push(done); channel.port2.postMessage(0); });

  /* ---- data -------------------------------------------------------------- */

  const TYPES = { u8: Uint8Array, i8: Int8Array, u16: Uint16Array, i16: Int16Array, f16: Uint16Array, u32: Uint32Array,
    f32: Float32Array };

  function bytesOfBase64(text) {
    const raw = atob(text), bytes = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
    return bytes;
  }

  async function inflated(bytes) {
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  /* Planes of bytes to numbers. */
  function together(planes, Type) {
    const size = Type.BYTES_PER_ELEMENT, n = planes.length / size, bytes = new Uint8Array(planes.length);
    for (let b = 0; b < size; b++)
      for (let i = 0, from = b * n, to = b; i < n; i++, to += size) bytes[to] = planes[from + i];
    return new Type(bytes.buffer);
  }

  async function readSections() {
    const blob = bytesOfBase64($('data').textContent.trim()), sections = {};
    let at = 0;
    const parts = meta.sections.map(s => {
      const part = blob.subarray(at, at += s.bytes);
      return s.coding.includes('zlib') ? inflated(part) : part;
    });
    for (const [i, s] of meta.sections.entries()) {
      const numbers = together(await parts[i], TYPES[s.type]);
      if (s.coding.includes('delta')) {
        const columns = s.shape[1] || 1;
        for (let i = columns; i < numbers.length; i++) numbers[i] += numbers[i - columns];
      }
      sections[s.name] = numbers;
    }
    return sections;
  }

  /* The number of every half. */
  function halves() {
    const table = new Float32Array(65536);
    for (let h = 0; h < 65536; h++) {
      const sign = h & 0x8000 ? -1 : 1, e = h >> 10 & 31, m = h & 1023;
      table[h] = sign * (e === 0 ? m * 2 ** -24 : e === 31 ? (m ? NaN : Infinity) : (1 + m / 1024) * 2 ** (e - 15));
    }
    return table;
  }

  /* Rows [points][4 or 1][ROW] to [points][ROW][4], scaled. */
  function interleave(data, to, scale) {
    for (let p = 0, from = 0; from < data.length; p++)
      for (let r = 0; r < (meta.sides ? 1 : 4); r++)
        for (let i = 0, q = 4 * p * ROW + r; i < ROW; i++, q += 4) to[q] = scale * data[from++];
  }

  /* Rows of evaluated points, [points][ROW][4], with room for those of continuity. */
  function rowsOf(s) {
    const n = meta.counts.evaluated * ROW, rows = new Float32Array(meta.counts.points * ROW * 4), half = halfTable;
    if (meta.precision === 'few') interleave(s.data, rows, 2 ** meta.exponent);
    else if (meta.precision === 'half') for (let i = 0; i < 4 * n; i++) rows[i] = half[s.rows[i]];
    else if (meta.precision === 'float') rows.set(s.rows);
    else {
      for (let i = 0; i < n; i++) {
        const scale = 3 * Math.floor(i / ROW);
        rows[4 * i] = half[s.values[i]];
        for (let a = 0; a < 3; a++) rows[4 * i + a + 1] = s.slopes[3 * i + a] * s.scales[scale + a];
      }
    }
    return rows;
  }

  /* ---- points of continuity ------------------------------------------------ */

  const INTERPOLATION = meta.sides ? 2 : 0;  /* values alone have no slopes */
/*@INTERPOLATION@*/
/*@FEW@*/
/*@PROBES@*/
  /* What makes a point at place 0 .. 26 of a cell of that level: for its value and slopes, weights of the corners' numbers. */
  function recipe(place, edge) {
    const t = [place % 3 / 2, Math.floor(place / 3) % 3 / 2, Math.floor(place / 9) / 2], f = [], g = [], lists = [];
    for (let a = 0; a < 3; a++) {
      f[a] = values(t[a], edge[a]);
      g[a] = slopes(t[a], edge[a]);
    }
    for (let r = 0; r < (meta.sides ? 1 : 4); r++) {
      const w = new Array(32), use = f.map((x, a) => r === a + 1 ? g[a] : x), list = [];
      corner_weights(w, use[0], use[1], use[2]);
      for (let k = 0; k < 32; k++) if (w[k] !== 0) list.push(k % 8, Math.floor(k / 8), w[k]);
      lists.push(list);
    }
    return lists;
  }

  const isSided = (i, cells) => (cells[12 * i + 1] >>> 16 & 64) !== 0;

  /* Cell, place and point of each point of continuity, in the order in which they are made. */
  function births(cells) {
    const list = [], made = new Uint8Array(meta.counts.points), evaluated = meta.counts.evaluated;
    for (let c = 0; c < meta.counts.cells; c++) {
      const child = cells[12 * c];
      if (child === 0 || !(cells[12 * c + 1] & 256) || isSided(c, cells)) continue;
      for (let k = 0; k < 8; k++) {
        for (let i = 0; i < 8; i++) {
          const p = cells[12 * (child + k) + 4 + i];
          if (p < evaluated || p === 0xffffffff || made[p]) continue;
          made[p] = 1;
          list.push(c, (k & 1) + (i & 1) + 3 * ((k >> 1 & 1) + (i >> 1 & 1)) + 9 * ((k >> 2) + (i >> 2)), p);
        }
      }
    }
    return list;
  }

  /* Makes them, in slices of time; onSlice(share done) may return false to give up. */
  async function continueRows(rows, cells, list, onSlice) {
    const known = new Map();
    let last = performance.now();
    for (let b = 0; b < list.length; b += 3) {
      const c = 12 * list[b], place = list[b + 1], to = list[b + 2] * ROW * 4, level = cells[c + 1] & 255;
      const key = level * 27 + place;
      if (!known.has(key)) known.set(key, recipe(place, meta.unit.map(u => u * 2 ** (meta.depth - level))));
      const lists = known.get(key);
      for (let r = 0; r < lists.length; r++) {
        const w = lists[r];
        for (let i = 0; i < ROW; i++) rows[to + 4 * i + r] = 0;
        for (let k = 0; k < w.length; k += 6) {
          const pair = k + 3 < w.length, from = cells[c + 4 + w[k]] * ROW * 4 + w[k + 1], x = w[k + 2];
          const other = pair ? cells[c + 4 + w[k + 3]] * ROW * 4 + w[k + 4] : from, y = pair ? w[k + 5] : 0;
          for (let i = 0, q = to + r; i < 4 * ROW; i += 4) rows[q + i] += x * rows[from + i] + y * rows[other + i];
        }
      }
      if ((b & 255) === 0 && performance.now() - last > SLICE) {
        if (onSlice(b / list.length) === false) return false;
        await breath();
        last = performance.now();
      }
    }
    return true;
  }

  /* ---- the light of lamps ---------------------------------------------------- */

  /* Harmonics of the unit vector x, y, z = v/|v| and their slopes by v; s: 1/|v|. */
  function harmonics(x, y, z, s, Y, dY) {
/*@HARMONICS@*/
  }

  const NUMBERS = new Float64Array(COUNT * 4);  /* of a lamp of radiance 1: value and slopes of each coefficient */
  const basis = new Float64Array(COUNT), slopesOf = new Float64Array(3 * COUNT);

  /* Fills NUMBERS with the light of a sphere at a place; false where the place is in it. */
  function lightOf(lamp, x, y, z) {
    const vx = lamp[0] - x, vy = lamp[1] - y, vz = lamp[2] - z, d2 = vx * vx + vy * vy + vz * vz, r2 = lamp[3] * lamp[3];
    if (d2 <= r2) return false;
    const s = 1 / Math.sqrt(d2), ux = vx * s, uy = vy * s, uz = vz * s;
    const s2 = r2 / d2, alpha = Math.max(Math.sqrt(1 - s2), 1e-6), turn = s2 * s / alpha;  /* of alpha along the distance */
    harmonics(ux, uy, uz, s, basis, slopesOf);
    let p = 1, next = alpha, slope = 0, nextSlope = 1, bend = 0, nextBend = 0;  /* Legendre polynomials of alpha */
    for (let l = 0; l <= meta.lmax; l++) {
      let w, dw;
      if (l === 0) {
        w = 2 * Math.PI * s2 / (1 + alpha);
        dw = 2 * Math.PI * (-2 * s2 * s / (1 + alpha) - s2 * turn / ((1 + alpha) * (1 + alpha)));
      } else {
        const c = 2 * Math.PI / (l * (l + 1));
        w = c * s2 * nextSlope;
        dw = c * (-2 * s2 * s * nextSlope + s2 * nextBend * turn);
        const up = ((2 * l + 1) * alpha * next - l * p) / (l + 1);
        const rise = slope + (2 * l + 1) * next, curve = bend + (2 * l + 1) * nextSlope;
        p = next;
        next = up;
        slope = nextSlope;
        nextSlope = rise;
        bend = nextBend;
        nextBend = curve;
      }
      for (let k = l * l; k < (l + 1) * (l + 1); k++) {
        const y0 = dw * basis[k];
        NUMBERS[4 * k] = w * basis[k];
        NUMBERS[4 * k + 1] = -(y0 * ux + w * slopesOf[3 * k]);
        NUMBERS[4 * k + 2] = -(y0 * uy + w * slopesOf[3 * k + 1]);
        NUMBERS[4 * k + 3] = -(y0 * uz + w * slopesOf[3 * k + 2]);
      }
    }
    return true;
  }

  /* A lamp's radiance in the grid's channels. */
  function channelsOf(lamp) {
    return meta.channels === 3 ? lamp.slice(4, 7) : [LUMINANCE_R * lamp[4] + LUMINANCE_G * lamp[5] + LUMINANCE_B * lamp[6]];
  }

  /* Adds `sign` times a lamp's light at point p to rows of numbers; false where the point is in the lamp. */
  function addLamp(to, lamp, p, sign) {
    if (!lightOf(lamp, places[3 * p], places[3 * p + 1], places[3 * p + 2])) return false;
    const e = channelsOf(lamp), scale = sign * 2 ** meta.exponent;
    for (let c = 0, i = p * ROW * 4; c < meta.channels; c++) {
      const f = scale * e[c];
      for (let k = 0; k < 4 * COUNT; k++, i++) to[i] += f * NUMBERS[k];
    }
    return true;
  }

  /* ---- drawing ------------------------------------------------------------- */

  const canvas = $('canvas');
  let gl, sections, rows, mesh, edges, lampTexture, born;
  let places;              /* of points, [points][3]; NaN: the corner of no cell */
  let lamps = meta.lamps.map(l => l.slice());
  const programs = {};
  const FIRST = meta.light ? 'scene' : 'grid';  /* the mode at first */
  const state = { mode: FIRST, lines: false, lamps: true, lobes: false, exposure: meta.exposure, tone: meta.tone, from: null,
    at: null, up: null, fov: 45, samples: 4 };
  const MODES = { grid: 0, exact: 1, error: 2, estimated: 3, levels: 4, scene: 5 };

  function shader(kind, text) {
    const s = gl.createShader(kind);
    gl.shaderSource(s, text);
    gl.compileShader(s);
    return s;
  }

  /* Begins to make a program; the driver makes it meanwhile. */
  function beginProgram(name, vertex, fragment, defines) {
    if (programs[name]) return programs[name];
    const head = '#version 300 es\nprecision highp float;\nprecision highp int;\nprecision highp sampler2D;\n' +
      'precision highp usampler2D;\n' + (defines || '');
    const p = gl.createProgram(), shaders = [shader(gl.VERTEX_SHADER, head + vertex), shader(gl.FRAGMENT_SHADER, head + fragment)];
    for (const s of shaders) gl.attachShader(p, s);
    gl.linkProgram(p);
    return programs[name] = { p, shaders, places: null };
  }

  /* A program that is made, and where its uniforms are. */
  function ready(program) {
    const p = program.p;
    if (program.places) return program;
    if (!gl.getProgramParameter(p, gl.LINK_STATUS))
      throw new Error('shader: ' + [gl.getProgramInfoLog(p), ...program.shaders.map(s => gl.getShaderInfoLog(s))].join(' '));
    program.places = {};
    for (let i = gl.getProgramParameter(p, gl.ACTIVE_UNIFORMS) - 1; i >= 0; i--) {
      const u = gl.getActiveUniform(p, i).name.replace('[0]', '');
      program.places[u] = gl.getUniformLocation(p, u);
    }
    return program;
  }

  const text = id => $(id).textContent;

  function surfaceProgram(mode) {
    const name = 'surface ' + mode;
    if (programs[name]) return programs[name];
    const vertex = text('resolve-vertex');
    if (mode === 'scene') return beginProgram(name, vertex, text('seen-glsl') + text('probes-glsl') + text('scene-fragment'));
    const used = [], cosine = [], A = [], legendre = [];
    for (let l = 0; l <= meta.lmax; l++) {
      A[l] = meta.cosine[l];
      for (let m = 0; m < 2 * l + 1; m++) if (A[l] !== 0) { used.push(l * l + m); cosine.push(A[l]); }
      /* A_l (2l+1)/4pi times 2 pi, of l > 0 over l (l+1) */
      legendre[l] = A[l] * (2 * l + 1) / 2 / (l ? l * (l + 1) : 1);
    }
    const list = numbers => numbers.map(x => x.toExponential(9)).join(', ');
    const defines = `#define LMAX ${meta.lmax}\n#define CHANNELS ${meta.channels}\n#define MODE ${MODES[mode]}\n` +
      `#define UNIFORM ${meta.kind === 'uniform' ? 1 : 0}\n#define SIDES ${meta.sides ? 1 : 0}\n` +
      `#define INTERPOLATION ${INTERPOLATION}\n#define USED_COUNT ${used.length}\n#define MOST_FLATS ${MOST_FLATS}\n` +
      `const int USED[${used.length}] = int[](${used.join(', ')});\n` +
      `const float COSINE[${used.length}] = float[](${list(cosine)});\n` +
      `const float LEGENDRE[${meta.lmax + 1}] = float[](${list(legendre)});\n`;
    const walk = text('cells-glsl') + text('walk-glsl').replace('float weight[32];', 'float weight[32];\n' +
      text('interpolation-glsl') + text('harmonics-glsl'));
    return beginProgram(name, vertex, text('seen-glsl') + walk + text('surface-fragment'), defines);
  }

  const bufferProgram = () => beginProgram('buffer', text('surface-vertex'), text('buffer-fragment'));

  const lampProgram = () => beginProgram('lamps', text('lamp-vertex'), text('lamp-fragment'));
  const resolveProgram = () => beginProgram('resolve', text('resolve-vertex'), text('resolve-fragment'));

  function texture(unit, internal, width, height, format, type, data) {
    const t = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, t);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, internal, width, height, 0, format, type, data);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
    for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
    return t;
  }

  /* Numbers as texels of `per` numbers in rows of WIDE. */
  function padded(numbers, per, Type) {
    const height = Math.max(1, Math.ceil(numbers.length / per / WIDE));
    if (numbers.length === height * WIDE * per) return [numbers, height];
    const out = new Type(height * WIDE * per);
    out.set(numbers);
    return [out, height];
  }

  const isFew = meta.lamps.length <= 64 && meta.counts.evaluated <= 20000;
  const rowsFormat = () => isFew || meta.precision === 'float' ? gl.RGBA32F : gl.RGBA16F;
  const UNIT = { cells: 0, table: 1, rows: 2, lamps: 3, picture: 4, sides: 5, tree: 6, bricks: 7, places: 8, surfaces: 9,
    flats: 10 };

  function makeTextures() {
    let [data, height] = padded(sections.cells, 4, Uint32Array);
    texture(UNIT.cells, gl.RGBA32UI, WIDE, height, gl.RGBA_INTEGER, gl.UNSIGNED_INT, data);
    [data, height] = padded(sections.table || new Uint32Array(1), 1, Uint32Array);
    texture(UNIT.table, gl.R32UI, WIDE, height, gl.RED_INTEGER, gl.UNSIGNED_INT, data);
    [data, height] = padded(sections.sides || new Uint32Array(1), 1, Uint32Array);
    texture(UNIT.sides, gl.R32UI, WIDE, height, gl.RED_INTEGER, gl.UNSIGNED_INT, data);
    makeRows();
    makeFlats();
    makeLamps();
  }

  let making = null;  /* signalled where the driver has made the programs that were begun */
  /* The driver ends to make programs when they draw for the first time: while the grid is decoded it draws what surfaces show of
     themselves, and lights the first rows by a grid of one cell without light. */
  function warm() {
    if (!making || !mesh || gl.getSyncParameter(making, gl.SYNC_STATUS) !== gl.SIGNALED) return;
    making = null;
    Object.values(programs).forEach(ready);
    const t = targetOf(1, 1);
    clear(t);
    fillSeen(t.w, t.h, 0, Math.min(t.h, Math.floor(MOST_SEEN / t.w)));
    if (state.mode !== 'scene') {
      const none = new Uint32Array(12);
      none[1] = 256;
      texture(UNIT.cells, gl.RGBA32UI, 3, 1, gl.RGBA_INTEGER, gl.UNSIGNED_INT, none);
      for (const name of ['table', 'sides'])
        texture(UNIT[name], gl.R32UI, 1, 1, gl.RED_INTEGER, gl.UNSIGNED_INT, none.subarray(0, 1));
      texture(UNIT.rows, rowsFormat(), ROW, 1, gl.RGBA, gl.FLOAT, new Float32Array(4 * ROW));
      texture(UNIT.flats, gl.RGBA32F, 1, 1, gl.RGBA, gl.FLOAT, new Float32Array(4));
      light(t, 0, 8, 1);
    }
    makeLamps();
    if (state.lamps) drawLamps(t);
    resolve(t);
    gl.flush();
  }

  let probeUniforms;
  /* The scene's light, in the form of engines: docs/engines.md. */
  function makeProbes(p) {
    texture(UNIT.tree, gl.RG32I, p.tree.width, p.tree.height, gl.RG_INTEGER, gl.INT, p.tree.data);
    gl.activeTexture(gl.TEXTURE0 + UNIT.bricks);
    gl.bindTexture(gl.TEXTURE_3D, gl.createTexture());
    gl.texImage3D(gl.TEXTURE_3D, 0, gl.RGBA16F, ...p.atlas.size, 0, gl.RGBA, gl.HALF_FLOAT, p.atlas.data);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_3D, name, gl.LINEAR);
    probeUniforms = { ylm_tree: ['1i', UNIT.tree], ylm_bricks: ['1i', UNIT.bricks] };
    for (const [name, x] of Object.entries(p.uniforms)) probeUniforms[name] = x.length ? ['3f', ...x] : ['1f', x];
  }

  let rowsTexture;
  /* The numbers of points to the graphics driver. */
  function makeRows() {
    const height = Math.max(1, Math.ceil(rows.length / 4 / WIDE));
    flats = 0;
    if (!rowsTexture) rowsTexture = texture(UNIT.rows, rowsFormat(), WIDE, height, gl.RGBA, gl.FLOAT, null);
    gl.activeTexture(gl.TEXTURE0 + UNIT.rows);
    const full = Math.floor(rows.length / 4 / WIDE);
    if (full) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, WIDE, full, gl.RGBA, gl.FLOAT, rows.subarray(0, full * WIDE * 4));
    const rest = rows.length / 4 - full * WIDE;
    if (rest) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, full, rest, 1, gl.RGBA, gl.FLOAT, rows.subarray(full * WIDE * 4));
  }

  const MOST_FLATS = 8, MOST_FLAT_TEXELS = 1 << 20;
  let flatNormals = null, flats = 0;  /* of the surfaces that have a texture of their own; how many it holds now */

  /* The normals that most of a mesh has, both sides of each: those of triangles without curvature, a fiftieth of its area or more. */
  function findFlats() {
    const t = sections.triangles, o = sections.normals, q = sections.positions, s = meta.mesh.step, areas = new Map();
    let all = 0;
    for (let i = 0; i < t.length; i += 3) {
      const a = t[i], b = t[i + 1], c = t[i + 2], A = 3 * a, B = 3 * b, C = 3 * c;
      const ux = s[0] * (q[B] - q[A]), uy = s[1] * (q[B + 1] - q[A + 1]), uz = s[2] * (q[B + 2] - q[A + 2]);
      const vx = s[0] * (q[C] - q[A]), vy = s[1] * (q[C + 1] - q[A + 1]), vz = s[2] * (q[C + 2] - q[A + 2]);
      const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx, area = Math.sqrt(x * x + y * y + z * z);
      all += area;
      if (o[2 * a] !== o[2 * b] || o[2 * a] !== o[2 * c] || o[2 * a + 1] !== o[2 * b + 1] || o[2 * a + 1] !== o[2 * c + 1]) continue;
      const key = 65536 * (o[2 * a] + 32768) + o[2 * a + 1] + 32768;
      areas.set(key, (areas.get(key) || 0) + area);
    }
    const most = Math.min(MOST_FLATS, Math.floor(MOST_FLAT_TEXELS / meta.counts.points / meta.channels)), list = [];
    for (const [key] of [...areas].filter(x => x[1] > all / 50).sort((a, b) => b[1] - a[1] || a[0] - b[0])) {
      const x = (Math.floor(key / 65536) - 32768) / 32767, y = (key % 65536 - 32768) / 32767, z = 1 - Math.abs(x) - Math.abs(y);
      const n = unitOf(z < 0 ? [(1 - Math.abs(y)) * (x < 0 ? -1 : 1), (1 - Math.abs(x)) * (y < 0 ? -1 : 1), z] : [x, y, z]);
      for (const m of [n, n.map(c => -c)])
        if (list.length < most && !list.some(k => Math.hypot(...sub(k, m)) < 1e-4)) list.push(m);
    }
    return list;
  }

  /* Irradiance of flat surfaces at all points, from rows as they are: a pixel of these needs no coefficients. */
  function makeFlats() {
    flatNormals = flatNormals || (mesh ? findFlats() : []);
    const n = meta.counts.points, data = new Float32Array(4 * Math.max(1, flatNormals.length * n * meta.channels));
    let to = 0;
    for (const normal of flatNormals) {
      harmonics(...normal, 1, basis, slopesOf);
      const factors = basis.map((y, k) => y * meta.cosine[Math.floor(Math.sqrt(k))]);
      for (let at = 0; at < 4 * n * ROW; to += 4) {
        let x = 0, dx = 0, dy = 0, dz = 0;
        for (let k = 0; k < COUNT; k++, at += 4) {
          const f = factors[k];
          if (f === 0) continue;
          x += f * rows[at];
          dx += f * rows[at + 1];
          dy += f * rows[at + 2];
          dz += f * rows[at + 3];
        }
        data[to] = x;
        data[to + 1] = dx;
        data[to + 2] = dy;
        data[to + 3] = dz;
      }
    }
    const [texels, height] = padded(data, 4, Float32Array);
    texture(UNIT.flats, gl.RGBA32F, WIDE, height, gl.RGBA, gl.FLOAT, texels);
    flats = flatNormals.length;
  }

  function makeLamps() {
    const list = [];
    for (const l of lamps) list.push(l[0], l[1], l[2], l[3], l[4], l[5], l[6], 0);
    const [data, height] = padded(new Float32Array(list), 4, Float32Array);
    if (lampTexture) gl.deleteTexture(lampTexture);
    lampTexture = texture(UNIT.lamps, gl.RGBA32F, WIDE, height, gl.RGBA, gl.FLOAT, data);
  }

  function buffer(data, target) {
    const b = gl.createBuffer();
    gl.bindBuffer(target || gl.ARRAY_BUFFER, b);
    gl.bufferData(target || gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    return b;
  }

  function makeMesh() {
    if (!sections.triangles || sections.triangles.length === 0) return null;
    const vao = gl.createVertexArray();
    gl.bindVertexArray(vao);
    [[sections.positions, 3, gl.UNSIGNED_SHORT], [sections.normals, 2, gl.SHORT], [sections.albedo, 3, gl.UNSIGNED_SHORT]]
      .forEach(([data, size, type], i) => {
        buffer(data);
        gl.enableVertexAttribArray(i);
        gl.vertexAttribPointer(i, size, type, false, 0, 0);
      });
    buffer(sections.triangles, gl.ELEMENT_ARRAY_BUFFER);
    gl.bindVertexArray(null);
    return { vao, n: sections.triangles.length, boxes: boxesOf(sections.triangles, sections.positions) };
  }

  const PIECE = 3 * 512;  /* corners of triangles that are drawn or left out together */

  /* Of each piece of a mesh the lowest and the highest of its positions. */
  function boxesOf(triangles, positions) {
    const boxes = new Uint16Array(6 * Math.ceil(triangles.length / PIECE));
    for (let from = 0, b = 0; from < triangles.length; from += PIECE, b += 6) {
      boxes.fill(65535, b, b + 3);
      for (let i = from; i < Math.min(from + PIECE, triangles.length); i++)
        for (let a = 0, x = 3 * triangles[i]; a < 3; a++, x++) {
          if (positions[x] < boxes[b + a]) boxes[b + a] = positions[x];
          if (positions[x] > boxes[b + 3 + a]) boxes[b + 3 + a] = positions[x];
        }
    }
    return boxes;
  }

  /* Can a box's picture by a matrix meet the rows low .. high, -1 .. 1 of the height? It can where a corner is behind the camera. */
  function meets(box, m, low, high) {
    let left = 1, right = 1, below = 1, above = 1;
    for (let k = 0; k < 8; k++) {
      const p = [0, 1, 2].map(a => meta.mesh.lowest[a] + meta.mesh.step[a] * box[k >> a & 1 ? 3 + a : a]);
      const [x, y, , w] = [0, 1, 2, 3].map(r => m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r]);
      if (w <= 0) return true;
      left &= x < -w;
      right &= x > w;
      below &= y < low * w;
      above &= y > high * w;
    }
    return !(left | right | below | above);
  }

  /* Where pieces of the mesh that those rows can show begin and end, in turn. */
  function piecesWithin(m, low, high) {
    const ends = [];
    for (let b = 0, from = 0; from < mesh.n; b += 6, from += PIECE) {
      if (!meets(mesh.boxes.subarray(b, b + 6), m, low, high)) continue;
      if (ends[ends.length - 1] === from) ends.pop();
      else ends.push(from);
      ends.push(Math.min(from + PIECE, mesh.n));
    }
    return ends;
  }

  function drawPieces(ends) {
    for (let i = 0; i < ends.length; i += 2)
      gl.drawElements(gl.TRIANGLES, ends[i + 1] - ends[i], gl.UNSIGNED_INT, 4 * ends[i]);
  }

  const mixed = (a, b, t) => a.map((x, i) => x + t * (b[i] - x));
  function painted(t) {
    t = Math.min(Math.max(t, 0), 1) * 15;
    const i = Math.min(Math.floor(t), 14);
    return mixed(meta.palette[i], meta.palette[i + 1], t - i);
  }

  const edgeOf = level => meta.kind === 'uniform' ? 1 : 2 ** (meta.depth - level);
  const placeOf = at => at.map((x, a) => meta.bounds[a] + meta.unit[a] * x);

  /* Origin, edge (lattice units), level, flags and estimated error's bits of a cell. */
  function cellAt(i) {
    const c = sections.cells, w = c[12 * i + 1], level = w & 255;
    return { origin: [c[12 * i + 2] & 65535, c[12 * i + 2] >>> 16, c[12 * i + 3] & 65535], level, edge: edgeOf(level),
      whole: (w & 256) !== 0, flags: w >>> 16, error: halfTable[c[12 * i + 3] >>> 16] };
  }
  const halfTable = halves();

  /* Where points are, from the cells and parts that they are corners of. */
  function placesOf(cells) {
    const out = new Float64Array(3 * meta.counts.points).fill(NaN);
    for (let i = 0; i < meta.counts.cells + meta.counts.parts; i++) {
      const c = cellAt(i);
      for (let k = 0; k < 8; k++) {
        const p = cells[12 * i + 4 + k];
        if (p === 0xffffffff || out[3 * p] === out[3 * p]) continue;
        const at = placeOf(c.origin.map((x, a) => x + (k >> a & 1) * c.edge));
        for (let a = 0; a < 3; a++) out[3 * p + a] = at[a];
      }
    }
    return out;
  }

  /* The edges of leaves that have light, each once, coarse ones first: finer ones cover them. */
  function makeEdges() {
    const seen = new Set(), byLevel = [];
    for (let i = 0; i < meta.counts.octree; i++) {
      const c = cellAt(i);
      if (!(c.flags & 1) || !c.whole) continue;
      const list = byLevel[c.level] = byLevel[c.level] || [], colour = painted(c.level / Math.max(meta.depth, 1));
      for (let a = 0; a < 3; a++) {
        for (let k = 0; k < 4; k++) {
          const from = c.origin.slice();
          from[(a + 1) % 3] += (k & 1) * c.edge;
          from[(a + 2) % 3] += (k >> 1) * c.edge;
          const key = ((from[0] * 65537 + from[1]) * 65537 + from[2]) * 3 + a + ':' + c.edge;
          if (seen.has(key)) continue;
          seen.add(key);
          const to = from.slice();
          to[a] += c.edge;
          list.push(...placeOf(from), ...placeOf(to), ...colour);
        }
      }
    }
    return lines([].concat(...byLevel.filter(x => x)));
  }

  /* Lines of nine numbers each: from, to, colour. */
  function lines(numbers) {
    const vao = gl.createVertexArray();
    gl.bindVertexArray(vao);
    buffer(new Float32Array(numbers));
    for (let i = 0; i < 3; i++) {
      gl.enableVertexAttribArray(i);
      gl.vertexAttribPointer(i, 3, gl.FLOAT, false, 36, 12 * i);
      gl.vertexAttribDivisor(i, 1);
    }
    gl.bindVertexArray(null);
    return { vao, n: numbers.length / 9 };
  }

  /* ---- lobes, and a cell that was chosen ------------------------------------------ */

  const LOBES = 256;  /* probes nearest to what the camera looks at */
  let ball = null, lobes = null, chosen = null;

  /* Directions and triangles of a sphere, an octahedron split three times. */
  function makeBall() {
    let faces = [];
    const axes = [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]];
    for (let i = 0; i < 4; i++) {
      faces.push([axes[i], axes[(i + 1) % 4], [0, 0, 1]], [axes[(i + 1) % 4], axes[i], [0, 0, -1]]);
    }
    for (let n = 0; n < 3; n++) {
      const finer = [];
      for (const [a, b, c] of faces) {
        const [x, y, z] = [[a, b], [b, c], [c, a]].map(([p, q]) => unitOf(p.map((s, i) => s + q[i])));
        finer.push([a, x, z], [x, b, y], [z, y, c], [x, y, z]);
      }
      faces = finer;
    }
    return { numbers: new Float32Array(faces.flat(2)), n: 3 * faces.length };
  }

  /* Instances of lobes for points: where, which, how large, in which colour. */
  function makeLobes(points, sizeOfPoint) {
    ball = ball || makeBall();
    const numbers = [];
    for (const p of points) {
      let square = 0;
      const mean = [];
      for (let c = 0; c < meta.channels; c++) mean[c] = Math.max(rows[(p * ROW + c * COUNT) * 4], 0);
      for (let i = 0; i < ROW; i++) square += rows[(p * ROW + i) * 4] ** 2;
      const norm = Math.sqrt(square / meta.channels), most = Math.max(...mean);
      if (!(norm > 0)) continue;
      const tint = [0, 1, 2].map(c => most > 0 ? 0.25 + 0.75 * mean[meta.channels === 3 ? c : 0] / most : 0.7);
      numbers.push(places[3 * p], places[3 * p + 1], places[3 * p + 2], p, 0.6 * sizeOfPoint(p) / norm, ...tint);
    }
    const vao = gl.createVertexArray();
    gl.bindVertexArray(vao);
    buffer(ball.numbers);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    buffer(new Float32Array(numbers));
    [[1, 3, 0], [2, 2, 12], [3, 3, 20]].forEach(([i, n, at]) => {
      gl.enableVertexAttribArray(i);
      gl.vertexAttribPointer(i, n, gl.FLOAT, false, 32, at);
      gl.vertexAttribDivisor(i, 1);
    });
    gl.bindVertexArray(null);
    return { vao, n: numbers.length / 8 };
  }

  let edgeOfPoint;  /* the shortest edge of a leaf at each point, scene units */
  function findEdges() {
    edgeOfPoint = new Float32Array(meta.counts.points).fill(Infinity);
    for (let i = 0; i < meta.counts.cells + meta.counts.parts; i++) {
      const c = cellAt(i);
      if (!(c.flags & 1) || !c.whole || (i >= meta.counts.octree && i < meta.counts.cells)) continue;
      const edge = c.edge * Math.min(...meta.unit);
      for (let k = 0; k < 8; k++) {
        const p = sections.cells[12 * i + 4 + k];
        edgeOfPoint[p] = Math.min(edgeOfPoint[p], edge);
      }
    }
  }

  /* The lobes of the probes nearest to what the camera looks at; ghosts stand where no probe is. */
  function nearLobes() {
    if (!edgeOfPoint) findEdges();
    const list = [];
    for (let p = 0; p < meta.counts.evaluated; p++) {
      if (edgeOfPoint[p] < Infinity && !(sections.flags[p] & 8)) list.push([Math.hypot(...[0, 1, 2].map(a => places[3 * p + a] - state.at[a])), p]);
    }
    list.sort((a, b) => a[0] - b[0] || a[1] - b[1]);
    return makeLobes(list.slice(0, LOBES).map(x => x[1]), p => edgeOfPoint[p]);
  }

  function dropLobes() {
    for (const one of [lobes, chosen && chosen.lobes]) if (one) gl.deleteVertexArray(one.vao);
    lobes = null;
    if (chosen) chosen.lobes = null;
  }

  /* ---- camera ---------------------------------------------------------------- */

  const sub = (a, b) => a.map((x, i) => x - b[i]), dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unitOf = a => { const n = Math.sqrt(dot(a, a)); return a.map(x => x / n); };
  const plus = (a, b, t) => a.map((x, i) => x + t * b[i]);

  function frame() {
    const forward = unitOf(sub(state.at, state.from)), right = unitOf(cross(forward, state.up));
    return { forward, right, up: cross(right, forward) };
  }

  /* The matrix that takes places to the picture, by columns; `near` of it. */
  function cameraMatrix(aspect) {
    const f = frame(), e = state.from, b = meta.bounds, centre = [0, 1, 2].map(i => (b[i] + b[i + 3]) / 2);
    const reach = Math.hypot(b[3] - b[0], b[4] - b[1], b[5] - b[2]) / 2;
    const away = Math.hypot(...sub(centre, e)), far = (away + reach) * 1.1 + reach, near = Math.max(far / 4e3, away - 4 * reach);
    const t = 1 / Math.tan(state.fov * Math.PI / 360), z = (far + near) / (far - near), q = -2 * far * near / (far - near);
    const m = [];
    for (let i = 0; i < 3; i++) m.push(f.right[i] * t / aspect, f.up[i] * t, z * f.forward[i], f.forward[i]);
    m.push(-dot(f.right, e) * t / aspect, -dot(f.up, e) * t, q - z * dot(f.forward, e), -dot(f.forward, e));
    return { m, near };
  }

  /* ---- pictures ---------------------------------------------------------------- */

  let target = null, shownTarget = null;  /* what is drawn into; what is on the screen */
  let perPixel = 0;                       /* ms, measured */
  let size = [1, 1];

  /* A picture of `samples` squared samples a pixel, or of a share of the pixels. */
  function targetOf(samples, share) {
    const w = Math.max(1, Math.ceil(size[0] * share)) * samples, h = Math.max(1, Math.ceil(size[1] * share)) * samples;
    if (!target || target.w !== w || target.h !== h) {
      if (target) {
        gl.deleteFramebuffer(target.f);
        gl.deleteTexture(target.t);
        gl.deleteRenderbuffer(target.d);
      }
      const t = texture(UNIT.picture, gl.RGBA16F, w, h, gl.RGBA, gl.HALF_FLOAT, null);
      const d = gl.createRenderbuffer(), f = gl.createFramebuffer();
      gl.bindRenderbuffer(gl.RENDERBUFFER, d);
      gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, w, h);
      gl.bindFramebuffer(gl.FRAMEBUFFER, f);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, t, 0);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, d);
      if (gl.checkFramebufferStatus(gl.FRAMEBUFFER) !== gl.FRAMEBUFFER_COMPLETE)
        throw new Error('this graphics driver draws no float pictures');
      target = { f, t, d, w, h };
      shownTarget = null;
    }
    target.samples = samples;
    target.share = share;
    return target;
  }

  function uniforms(begun, values) {
    const pr = ready(begun);
    gl.useProgram(pr.p);
    for (const [name, [kind, ...x]] of Object.entries(values)) {
      const at = pr.places[name];
      if (at) gl['uniform' + kind](at, ...x);
    }
  }

  let seen = null;             /* what surfaces show of themselves at the samples of some rows */
  const MOST_SEEN = 1 << 22;   /* samples */

  /* Fills it for rows from .. to of a picture of w x h samples, unless it has them. */
  function fillSeen(w, h, from, to) {
    const { m } = cameraMatrix(size[0] / size[1]), key = [w, h, from, to, ...m].join();
    if (seen && seen.key === key) return;
    if (!seen || seen.w !== w || seen.rows !== to - from) {
      if (seen) {
        gl.deleteFramebuffer(seen.f);
        for (const t of seen.textures) gl.deleteTexture(t);
        gl.deleteRenderbuffer(seen.d);
      }
      const f = gl.createFramebuffer(), d = gl.createRenderbuffer(), textures = [UNIT.places, UNIT.surfaces].map(unit =>
        texture(unit, gl.RGBA32UI, w, to - from, gl.RGBA_INTEGER, gl.UNSIGNED_INT, null));
      gl.bindRenderbuffer(gl.RENDERBUFFER, d);
      gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, w, to - from);
      gl.bindFramebuffer(gl.FRAMEBUFFER, f);
      textures.forEach((t, i) => gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, t, 0));
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, d);
      gl.drawBuffers([gl.COLOR_ATTACHMENT0, gl.COLOR_ATTACHMENT1]);
      seen = { f, d, textures, w, rows: to - from };
    }
    Object.assign(seen, { key, below: from });
    gl.bindFramebuffer(gl.FRAMEBUFFER, seen.f);
    gl.viewport(0, -from, w, h);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LESS);
    for (const i of [0, 1]) gl.clearBufferuiv(gl.COLOR, i, [0, 0, 0, 0]);
    gl.clearBufferfv(gl.DEPTH, 0, [1]);
    gl.bindVertexArray(mesh.vao);
    uniforms(bufferProgram(), { camera: ['Matrix4fv', false, m], eye: ['3f', ...state.from],
      mesh_lowest: ['3f', ...meta.mesh.lowest], mesh_step: ['3f', ...meta.mesh.step] });
    drawPieces(piecesWithin(m, 2 * from / h - 1, 2 * to / h - 1));
  }

  /* Makes a target ready to be drawn into. */
  function clear(t) {
    gl.bindFramebuffer(gl.FRAMEBUFFER, t.f);
    gl.viewport(0, 0, t.w, t.h);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.clearColor(...meta.background, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  }

  /* Rows from .. to of a target, whose surfaces are seen: a sample of `stride` squared of them. */
  function light(t, from, to, stride) {
    gl.bindFramebuffer(gl.FRAMEBUFFER, t.f);
    gl.viewport(0, 0, t.w, t.h);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.ALWAYS);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(0, from, t.w, to - from);
    gl.bindVertexArray(null);
    uniforms(surfaceProgram(state.mode), Object.assign({
      eye: ['3f', ...state.from], cells: ['1i', UNIT.cells], table: ['1i', UNIT.table], rows: ['1i', UNIT.rows],
      lamps: ['1i', UNIT.lamps], lowest: ['3f', ...meta.bounds.slice(0, 3)], unit: ['3f', ...meta.unit],
      resolution: ['3f', ...meta.resolution], depth: ['1i', meta.depth], scale: ['1f', 2 ** -meta.exponent],
      sides: ['1i', UNIT.sides], lamp_count: ['1i', lamps.length], palette: ['3fv', [].concat(...meta.palette)],
      range: ['2f', ...meta.range], places: ['1i', UNIT.places], surfaces: ['1i', UNIT.surfaces], stride: ['1i', stride],
      below: ['1i', seen.below], flats: ['1i', UNIT.flats], flat_count: ['1i', flats], points: ['1i', meta.counts.points],
      flat_normals: ['3fv', flats ? [].concat(...flatNormals) : [0, 0, 0]],
    }, probeUniforms));
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.disable(gl.SCISSOR_TEST);
  }

  /* Lines, lobes and lamps over the surfaces of a target. */
  function drawThings(t) {
    const { m, near } = cameraMatrix(size[0] / size[1]), matrix = ['Matrix4fv', false, m];
    gl.bindFramebuffer(gl.FRAMEBUFFER, t.f);
    gl.viewport(0, 0, t.w, t.h);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    if (state.lines) {
      edges = edges || makeEdges();
      uniforms(beginProgram('edges', text('edge-vertex'), text('flat-fragment')), { camera: matrix, near: ['1f', near],
        pixels: ['2f', t.w, t.h], width: ['1f', Math.max(1, 1.2 * t.samples * t.share * (window.devicePixelRatio || 1))] });
      gl.bindVertexArray(edges.vao);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, edges.n);
    }
    if (chosen) {
      uniforms(beginProgram('edges', text('edge-vertex'), text('flat-fragment')), { camera: matrix, near: ['1f', near],
        pixels: ['2f', t.w, t.h], width: ['1f', 2 * t.samples * t.share * (window.devicePixelRatio || 1)] });
      gl.bindVertexArray(chosen.box.vao);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, chosen.box.n);
    }
    if (state.lobes || chosen) {
      const head = `#define LMAX ${meta.lmax}\n#define CHANNELS ${meta.channels}\n`;
      const vertex = text('lobe-vertex').replace('float Y[COUNT];', 'float Y[COUNT];\n' + text('harmonics-glsl'));
      uniforms(beginProgram('lobes', vertex, text('flat-fragment'), head), { camera: matrix, eye: ['3f', ...state.from],
        rows: ['1i', UNIT.rows] });
      if (state.lobes) lobes = lobes || nearLobes();
      if (chosen) chosen.lobes = chosen.lobes || makeLobes(chosen.corners, () => chosen.size);
      for (const one of [state.lobes && lobes, chosen && chosen.lobes]) {
        if (!one) continue;
        gl.bindVertexArray(one.vao);
        gl.drawArraysInstanced(gl.TRIANGLES, 0, ball.n, one.n);
      }
    }
    if (state.lamps) drawLamps(t);
  }

  /* The lamps, before what is behind them. */
  function drawLamps(t) {
    if (!lamps.length) return;
    const f = frame();
    gl.bindFramebuffer(gl.FRAMEBUFFER, t.f);
    gl.viewport(0, 0, t.w, t.h);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    uniforms(lampProgram(), { camera: ['Matrix4fv', false, cameraMatrix(size[0] / size[1]).m], eye: ['3f', ...state.from],
      right: ['3f', ...f.right], up: ['3f', ...f.up], lamps: ['1i', UNIT.lamps] });
    gl.bindVertexArray(null);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, lamps.length);
  }

  /* A target to the canvas, through exposure and tone curve. */
  function resolve(t) {
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, size[0], size[1]);
    gl.disable(gl.DEPTH_TEST);
    gl.bindVertexArray(null);
    uniforms(resolveProgram(), { picture: ['1i', UNIT.picture],
      samples: ['1i', t.samples], shrink: ['2f', t.w / t.samples / size[0], t.h / t.samples / size[1]],
      gain: ['1f', 2 ** state.exposure], tone: ['1i', TONES.indexOf(state.tone)] });
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /* A target to the window. */
  function show(t) {
    resolve(t);
    shownTarget = t;
    if (canvas.style.visibility !== 'visible') {
      canvas.style.visibility = 'visible';
      if ($('poster')) $('poster').style.display = 'none';
      $('note').className = '';
      if (rows) look();
      finish();
      performance.mark('first picture');
    }
  }

  /* Waits until the graphics driver has done what it was told. */
  function finish() {
    const pixel = new Uint8Array(4);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
  }

  function finishBand() {
    const pixel = new Float32Array(4);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.FLOAT, pixel);
  }

  let asked = 0, busy = false, moving = false, restTimer = 0;

  /* Something changed: it is drawn anew, coarse while it `moves`. */
  function change(moves) {
    asked++;
    root.dataset.state = 'drawing';
    if (moves) {
      moving = true;
      clearTimeout(restTimer);
      restTimer = setTimeout(() => { moving = false; change(false); }, 150);
    }
    if (!busy) requestAnimationFrame(() => { run(); });
  }

  /* A whole target, in strips of rows whose surfaces are seen together and bands of these that take about SLICE ms each; one sample
     of `stride` squared is lit. False where something changed meanwhile. */
  async function drawInBands(t, stride, mine) {
    let band = perPixel > 0 ? SLICE / perPixel / t.w : 16;
    const strip = Math.max(8, Math.floor(MOST_SEEN / (t.w * stride * stride)));
    clear(t);
    for (let low = 0; mesh && low < t.h; low += strip) {
      const high = Math.min(t.h, low + strip);
      fillSeen(stride * t.w, stride * t.h, stride * low, stride * high);
      for (let from = low, to = 0; from < high; from = to) {
        const began = performance.now();
        to = Math.min(high, from + Math.max(8, Math.floor(band)));
        light(t, from, to, stride);
        finishBand();
        const took = Math.max(1, performance.now() - began);
        perPixel = took / (to - from) / t.w;
        band = Math.min(2 * (to - from), SLICE / perPixel / t.w);
        await breath();
        if (asked !== mine) return false;
      }
    }
    drawThings(t);
    return true;
  }

  /* The scene's light, before the grid is decoded, which it does not need. */
  async function showScene() {
    makeLamps();
    const t = targetOf(1, 1);
    if (await drawInBands(t, 1, asked)) show(t);
  }

  async function run() {
    if (busy) return;
    busy = true;
    try {
      for (let mine = -1; mine !== asked;) {
        mine = asked;
        resize();
        if (stale) {
          const before = lampVersion, whole = await relight(moving);
          if (whole && before === lampVersion) stale = false;
          if (asked !== mine && !moving) continue;
        }
        if (moving) {
          const full = perPixel * size[0] * size[1], share = full <= BUDGET ? 1 : full <= 4 * BUDGET ? 0.5 : 0.25;
          const t = targetOf(1, share), began = performance.now();
          clear(t);
          if (mesh) {
            fillSeen(t.w, t.h, 0, t.h);
            light(t, 0, t.h, 1);
          }
          drawThings(t);
          show(t);
          finish();
          perPixel = 0.5 * perPixel + 0.5 * (performance.now() - began) / (t.w * t.h);
          await new Promise(requestAnimationFrame);
          continue;
        }
        const whole = state.samples === 1 ? [1] : state.still ? [2] : [1, 2];
        for (const samples of shownTarget || state.still ? whole : [0.5, ...whole]) {
          const t = samples < 1 ? targetOf(1, 0.5) : targetOf(samples, 1);
          if (!await drawInBands(t, samples < 1 ? 2 : 1, mine)) break;
          show(t);
        }
        if (asked === mine) {
          finish();
          root.dataset.state = 'ready';
        }
      }
    } catch (error) {
      fail('This page cannot be drawn: ' + error.message);
    }
    busy = false;
  }

  function resize() {
    const ratio = window.devicePixelRatio || 1;
    const w = Math.max(1, Math.round(canvas.clientWidth * ratio)), h = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (canvas.width !== w || canvas.height !== h) {
      canvas.width = w;
      canvas.height = h;
    }
    size = [w, h];
  }

  /* ---- what one can do ---------------------------------------------------------- */

  function home() {
    const c = meta.camera;
    state.from = c.slice(0, 3);
    state.at = c.slice(3, 6);
    state.up = unitOf(c.slice(6, 9));
    state.fov = c[9];
  }

  /* Why a mode cannot be shown; nothing where it can. */
  function lacks(mode) {
    if ((mode === 'exact' || mode === 'error') && meta.no_exact) return meta.no_exact;
    if (mode === 'scene' && !meta.light) return "the page has the grid's light alone";
    if (mode !== 'levels' && !meta.mesh) return 'the page has no geometry';
  }

  function setMode(mode) {
    const why = lacks(mode);
    if (why) return say(mode + ': ' + why);
    state.mode = state.mode !== mode ? mode : mode === 'scene' ? 'grid' : FIRST;
    look();
    change(false);
  }

  function shownAgain() {
    look();
    if (shownTarget && !busy) show(shownTarget);
    else change(false);
  }

  const actions = [
    { key: 'm', name: 'exact', about: 'the grid, or the lamps themselves at every pixel', on: () => state.mode === 'exact',
      run: () => setMode('exact') },
    { key: 'e', name: 'error', about: 'true error times 100: the grid against the lamps', on: () => state.mode === 'error',
      run: () => setMode('error') },
    { key: 'v', name: 'estimate', about: 'estimated error of cells, on a logarithmic scale', on: () => state.mode === 'estimated',
      run: () => setMode('estimated') },
    { key: 'c', name: 'levels', about: 'levels of cells as colours', on: () => state.mode === 'levels',
      run: () => setMode('levels') },
    { key: 'l', name: 'edges', about: 'edges of the octree', on: () => state.lines,
      run: () => { state.lines = !state.lines; look(); change(false); } },
    { key: 'k', name: 'lamps', about: 'lamps as one sees them', on: () => state.lamps,
      run: () => { state.lamps = !state.lamps; look(); change(false); } },
    { key: 'b', name: 'lobes', about: 'light at the 256 probes nearest to what the camera looks at', on: () => state.lobes,
      run: () => { state.lobes = !state.lobes; look(); change(false); } },
    ...(meta.light ? [{ key: 's', name: 'scene', about: "the scene's light with walls, shadows and bounces, or the grid's",
      on: () => state.mode === 'scene', run: () => setMode('scene') }] : []),
    { key: '+', name: '+', about: 'exposure up by a third of a stop', run: () => { state.exposure += 1 / 3; shownAgain(); } },
    { key: '-', name: '-', about: 'exposure down', run: () => { state.exposure -= 1 / 3; shownAgain(); } },
    { key: 'o', name: 'tone', about: 'next tone curve',
      run: () => { state.tone = TONES[(TONES.indexOf(state.tone) + 1) % TONES.length]; shownAgain(); } },
    { key: 'Home', name: 'home', about: "the scene's camera, lamps where they were",
      run: () => { home(); lampsHome(); dropLobes(); look(); change(false); } },
    { key: 'h', name: '?', about: 'this text', run: () => { $('help').hidden = !$('help').hidden; } },
  ];

  function makeBar() {
    for (const a of actions) {
      const b = document.createElement('button');
      b.textContent = a.name;
      b.title = a.about + ' (' + a.key + ')';
      b.onclick = () => { a.run(); canvas.focus(); };
      a.button = b;
      $('bar').appendChild(b);
    }
    $('help').textContent = actions.map(a => a.key.padEnd(5) + a.about).join('\n') +
      '\ndrag turns, the right button or two fingers shift, the wheel goes nearer;' +
      '\na lamp can be dragged, with Shift upright; a click says what the grid knows there';
  }

  /* A radiance, 0 .. 1 of the window's white, as resolve.frag.glsl shows it. */
  function shade(x) {
    const hable = v => (v * (0.15 * v + 0.05) + 0.004) / (v * (0.15 * v + 0.5) + 0.06) - 0.02 / 0.3;
    if (state.tone === 'reinhard') x = x / (1 + x);
    if (state.tone === 'hable') x = hable(2 * x) / hable(11.2);
    if (state.tone === 'aces') x = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
    x = Math.max(0, Math.min(1, x));
    return state.tone === 'linear' ? x : x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055;
  }

  const css = rgb => `rgb(${rgb.map(x => Math.round(255 * x)).join(' ')})`;

  /* What the colours of a mode mean: words, stops of a ramp, numbers below it; nothing of a mode that shows light. */
  function legendOf(mode) {
    const ends = list => list.map(x => +x.toPrecision(2));
    if (mode === 'error') {
      const white = { reinhard: 8, hable: 5.6, aces: 2 }[state.tone] || 1, stops = [];
      for (let i = 0; i <= 16; i++) { const x = shade(white * i / 16); stops.push(css([x, x, x])); }
      const most = white / 100 / 2 ** state.exposure;
      return ['|grid - lamps|, radiance, shown 100 times brighter', stops, ends([0, most / 2, most])];
    }
    const stops = meta.palette.map(css);
    if (mode === 'estimated') {
      const [low, high] = meta.range.map(Math.exp);
      return ['estimated error of a cell, logarithmic', stops, ends([low, Math.sqrt(low * high), high])];
    }
    if (mode === 'levels') return ['level of a cell', stops, meta.depth ? [0, meta.depth] : [0]];
  }

  function showLegend() {
    const legend = legendOf(state.mode), box = $('legend');
    box.hidden = !legend;
    if (!legend) return;
    const part = (name, text) => {
      const e = document.createElement('div');
      e.className = name;
      e.textContent = text || '';
      return e;
    };
    const ramp = part('ramp'), numbers = part('ends');
    ramp.style.background = `linear-gradient(to right, ${legend[1].join(', ')})`;
    for (const x of legend[2]) {
      const e = document.createElement('span');
      e.textContent = x;
      numbers.appendChild(e);
    }
    box.replaceChildren(part('words', legend[0]), ramp, numbers);
  }

  function look() {
    showLegend();
    for (const a of actions) {
      if (a.on) a.button.className = a.on() ? 'on' : '';
      a.button.disabled = a.name === 'exact' || a.name === 'error' ? !!lacks(a.name) : false;
      if (a.button.disabled) a.button.title = a.about + ': ' + lacks(a.name);
    }
    const s = meta.stats, words = [meta.title, s.points + ' probes', s.cells + ' cells', 'degree ' + meta.lmax];
    if (s.tolerance) words.push('tolerance ' + +s.tolerance.toPrecision(3) + (s.met ? ' met' : ' not met'));
    if (state.exposure) words.push((state.exposure > 0 ? '+' : '') + state.exposure.toFixed(1) + ' stops');
    if (state.tone !== 'srgb') words.push(state.tone);
    if (movedLamps) words.push('lamps have moved: cells are those of the bake');
    say(words.join(' · '));
  }

  function turn(dx, dy) {
    const f = frame(), d = sub(state.from, state.at), around = -dx * 0.006, over = -dy * 0.006;
    const spin = (v, axis, angle) => {
      const c = Math.cos(angle), s = Math.sin(angle), k = dot(axis, v) * (1 - c), x = cross(axis, v);
      return v.map((y, i) => y * c + x[i] * s + axis[i] * k);
    };
    let v = spin(d, state.up, around);
    const tilted = spin(v, spin(f.right, state.up, around), over);
    if (Math.abs(dot(unitOf(tilted), state.up)) < 0.995) v = tilted;
    state.from = state.at.map((x, i) => x + v[i]);
  }

  function shift(dx, dy) {
    const f = frame(), far = Math.hypot(...sub(state.at, state.from));
    const step = 2 * far * Math.tan(state.fov * Math.PI / 360) / canvas.clientHeight;
    for (const name of ['from', 'at']) state[name] = plus(plus(state[name], f.right, -dx * step), f.up, dy * step);
  }

  /* ---- lamps that are dragged ------------------------------------------------------- */

  let stale = false;       /* lamps have moved since the rows were made */
  let dragged = -1, base = null, movedLamps = 0, lampVersion = 0, relights = 0, relightTime = 0;

  /* The light of all lamps but one at evaluated points: of few lamps their sum, of many that of the page less the one's. */
  function beginDrag(i) {
    const n = meta.counts.evaluated, others = lamps.filter((_, j) => j !== i);
    dragged = i;
    if (others.length * n <= 1e6) {
      base = new Float32Array(n * ROW * 4);
      for (let p = 0; p < n; p++)
        if (places[3 * p] === places[3 * p]) for (const l of others) addLamp(base, l, p, 1);
    } else {
      base = rows.slice(0, n * ROW * 4);
      for (let p = 0; p < n; p++) {
        if (places[3 * p] !== places[3 * p]) continue;
        if (!sections.flags[p]) addLamp(base, lamps[i], p, -1);
        else {
          base.fill(0, p * ROW * 4, (p + 1) * ROW * 4);
          for (const l of others) addLamp(base, l, p, 1);
        }
      }
    }
  }

  /* Points in lamps take the mean of first-order expansions about the points beside them, finest cells first. */
  function fill(invalid) {
    const slot = new Map(invalid.map(p => [p, { weight: 0, sum: new Float64Array(ROW * 4) }])), byLevel = [];
    for (let i = 0; i < meta.counts.octree; i++) {
      const c = sections.cells;
      for (let k = 0; k < 8; k++) {
        if (!slot.has(c[12 * i + 4 + k])) continue;
        (byLevel[c[12 * i + 1] & 255] = byLevel[c[12 * i + 1] & 255] || []).push(i);
        break;
      }
    }
    for (let level = byLevel.length - 1; level >= 0; level--) {
      for (let any = true; any && byLevel[level];) {
        any = false;
        for (const i of byLevel[level]) {
          const corners = sections.cells.subarray(12 * i + 4, 12 * i + 12);
          for (const p of corners) {
            const to = slot.get(p);
            if (!to) continue;
            for (const q of corners) {
              if (q === 0xffffffff || slot.has(q)) continue;
              const dx = [0, 1, 2].map(a => places[3 * p + a] - places[3 * q + a]), w = 1 / dot(dx, dx);
              for (let j = 0, from = q * ROW * 4; j < ROW * 4; j += 4, from += 4) {
                to.sum[j] += w * (rows[from] + dx[0] * rows[from + 1] + dx[1] * rows[from + 2] + dx[2] * rows[from + 3]);
                for (let r = 1; r < 4; r++) to.sum[j + r] += w * rows[from + r];
              }
              to.weight += w;
              any = true;
            }
          }
        }
        for (const [p, to] of slot) {
          if (!(to.weight > 0)) continue;
          for (let j = 0; j < ROW * 4; j++) rows[p * ROW * 4 + j] = to.sum[j] / to.weight;
          slot.delete(p);
        }
      }
    }
  }

  /* Rows for lamps as they are: evaluated points, and those of continuity unless these take too long for a frame: false. */
  async function relight(hurried) {
    const n = meta.counts.evaluated, invalid = [], mine = asked;
    rows.set(base);
    for (let p = 0; p < n; p++) {
      if (dragged < 0 || places[3 * p] !== places[3 * p]) continue;
      let inside = !addLamp(rows, lamps[dragged], p, 1);
      for (let j = 0; j < lamps.length && !inside && sections.flags[p]; j++) {
        const d = [0, 1, 2].map(a => lamps[j][a] - places[3 * p + a]);
        inside = dot(d, d) <= lamps[j][3] ** 2;
      }
      if (inside) invalid.push(p);
    }
    if (invalid.length) fill(invalid);
    let whole = false;
    if (!hurried || relightTime < 60 || ++relights % 4 === 0) {
      const began = performance.now();
      whole = await continueRows(rows, sections.cells, born, () => hurried || asked === mine);
      if (whole) relightTime = performance.now() - began;
    }
    makeRows();
    if (whole && !hurried) makeFlats();
    makeLamps();
    dropLobes();
    return whole;
  }

  /* The direction of the ray through a pixel of the window. */
  function rayAt(x, y) {
    const f = frame(), t = Math.tan(state.fov * Math.PI / 360), h = canvas.clientHeight, w = canvas.clientWidth;
    return unitOf(plus(plus(f.forward, f.right, t * (2 * x - w) / h), f.up, t * (1 - 2 * y / h)));
  }

  /* The lamp under a pixel, or within `reach` pixels of it; -1: none. */
  function lampAt(x, y, reach) {
    if (!state.lamps || meta.no_exact || (stale && lamps.length * meta.counts.evaluated > 1e6)) return -1;
    const ray = rayAt(x, y), step = 2 * Math.tan(state.fov * Math.PI / 360) / canvas.clientHeight;
    let best = -1, near = Infinity;
    lamps.forEach((l, i) => {
      const v = sub(l.slice(0, 3), state.from), b = dot(v, ray);
      if (b <= 0 || b >= near) return;
      if (Math.hypot(...plus(v, ray, -b)) <= l[3] + reach * step * b) { best = i; near = b; }
    });
    return best;
  }

  let grip = null;  /* where a lamp was taken: its place, the pointer's there */

  function takeLamp(i, x, y) {
    grip = { x, y, at: lamps[i].slice(0, 3) };
    beginDrag(i);
  }

  /* In the plane that faces the camera; with `upright` along up alone. */
  function dragLamp(x, y, upright) {
    const f = frame(), v = sub(grip.at, state.from), far = dot(v, f.forward);
    const step = 2 * far * Math.tan(state.fov * Math.PI / 360) / canvas.clientHeight;
    const dx = (x - grip.x) * step, dy = -(y - grip.y) * step;
    const to = upright ? plus(grip.at, state.up, dy) : plus(plus(grip.at, f.right, dx), f.up, dy);
    for (let a = 0; a < 3; a++) lamps[dragged][a] = to[a];
    stale = true;
    movedLamps++;
    lampVersion++;
    $('corner').textContent = `lamp ${dragged + 1} at ${to.map(c => +c.toFixed(6)).join(' ')}`;
  }

  /* Lamps back to where the bake had them. */
  function lampsHome() {
    if (!movedLamps) return;
    lamps = meta.lamps.map(l => l.slice());
    movedLamps = 0;
    lampVersion++;
    base = rowsOf(sections).slice(0, meta.counts.evaluated * ROW * 4);
    dragged = -1;
    stale = true;
  }

  /* ---- a point that is asked about ------------------------------------------------------ */

  /* The distance along a ray to the nearest triangle, and its normal to the side of the ray's beginning; Infinity: there is none. */
  function hitAlong(from, ray) {
    const t = sections.triangles, q = sections.positions, m = meta.mesh;
    let best = Infinity, normal = null;
    const s = m.step, ox = (from[0] - m.lowest[0]), oy = (from[1] - m.lowest[1]), oz = (from[2] - m.lowest[2]);
    for (let i = 0; i < t.length; i += 3) {
      const a = 3 * t[i], b = 3 * t[i + 1], c = 3 * t[i + 2];
      const ax = s[0] * q[a], ay = s[1] * q[a + 1], az = s[2] * q[a + 2];
      const ux = s[0] * q[b] - ax, uy = s[1] * q[b + 1] - ay, uz = s[2] * q[b + 2] - az;
      const vx = s[0] * q[c] - ax, vy = s[1] * q[c + 1] - ay, vz = s[2] * q[c + 2] - az;
      const px = ray[1] * vz - ray[2] * vy, py = ray[2] * vx - ray[0] * vz, pz = ray[0] * vy - ray[1] * vx;
      const det = ux * px + uy * py + uz * pz;
      if (det === 0) continue;
      const tx = ox - ax, ty = oy - ay, tz = oz - az, u = (tx * px + ty * py + tz * pz) / det;
      if (u < 0 || u > 1) continue;
      const wx = ty * uz - tz * uy, wy = tz * ux - tx * uz, wz = tx * uy - ty * ux;
      const v = (ray[0] * wx + ray[1] * wy + ray[2] * wz) / det;
      if (v < 0 || u + v > 1) continue;
      const d = (vx * wx + vy * wy + vz * wz) / det;
      if (d <= 0 || d >= best) continue;
      best = d;
      normal = unitOf(cross([ux, uy, uz], [vx, vy, vz]).map(x => det > 0 ? x : -x));
    }
    return { distance: best, normal };
  }

  const WAYS = [1, 1.7, 0.5];

  /* The cell of the part that a surface at x sees in a leaf with sides, as seen_part of walk.glsl; -1: nothing of it is free. */
  function partAt(leaf, x, normal) {
    const s = sections.sides, from = sections.cells[12 * leaf], first = s[from], c = cellAt(leaf);
    if (s[from + 1] < 2) return s[from + 1] ? first : -1;
    const partOf = i => s[from + 2 + (i >> 3)] >>> 4 * (i & 7) & 15;
    const edge = meta.unit.map(u => u * c.edge), thick = 0.1875 * edge.reduce((sum, e, a) => sum + Math.abs(normal[a]) * e, 0);
    const place = way => x.map((p, a) => ((p - meta.bounds[a]) / meta.unit[a] - c.origin[a]) / c.edge +
      way * thick * normal[a] / edge[a]);
    for (const way of WAYS) {
      const q = place(way).map(t => Math.min(Math.max(Math.floor(4 * t) + 1, 0), 5)), part = partOf(q[0] + 6 * q[1] + 36 * q[2]);
      if (part !== 15) return first + part;
    }
    const front = place(1);
    let best = -1, least = Infinity;
    for (let i = 0; i < 216; i++) {
      if (partOf(i) === 15) continue;
      const d = Math.hypot(...[i % 6, Math.floor(i / 6) % 6, Math.floor(i / 36)].map((k, a) => ((k - 0.5) / 4 - front[a]) * edge[a]));
      if (d < least) { least = d; best = partOf(i); }
    }
    return first + best;
  }

  /* The leaf of the octree at a place on a surface, and the cell whose corners are interpolated there; -1: none. */
  function locate(x, normal) {
    const found = walkTo(x);
    if (found.leaf >= 0 && isSided(found.leaf, sections.cells)) found.whole = partAt(found.leaf, x, normal);
    return found;
  }

  function walkTo(x) {
    const at = x.map((c, a) => Math.min(Math.max((c - meta.bounds[a]) / meta.unit[a], 0), meta.resolution[a]));
    const q = at.map((c, a) => Math.min(Math.floor(c), meta.resolution[a] - 1));
    if (meta.kind === 'uniform') {
      const i = sections.table[(q[2] * meta.resolution[1] + q[1]) * meta.resolution[0] + q[0]];
      return { at, leaf: i === 0xffffffff ? -1 : i, whole: i === 0xffffffff ? -1 : i };
    }
    let i = 0, leaf = 0, whole = -1;
    for (let n = 0; n <= 16; n++) {
      const c = cellAt(i), child = sections.cells[12 * i];
      if (!(c.flags & 16)) leaf = i;
      if (c.whole) whole = i;
      if (!child || c.flags & 64) break;
      const bit = meta.depth - c.level - 1;
      i = child + (q[0] >> bit & 1) + 2 * (q[1] >> bit & 1) + 4 * (q[2] >> bit & 1);
    }
    return { at, leaf, whole };
  }

  /* The grid's coefficients at a place. */
  function sample(found) {
    const c = cellAt(found.whole), out = new Float64Array(ROW), w = new Array(32), scale = 2 ** -meta.exponent;
    const f = [0, 1, 2].map(a => values(Math.min(Math.max((found.at[a] - c.origin[a]) / c.edge, 0), 1), c.edge * meta.unit[a]));
    corner_weights(w, f[0], f[1], f[2]);
    for (let k = 0; k < 32; k++) {
      const from = sections.cells[12 * found.whole + 4 + k % 8] * ROW * 4 + Math.floor(k / 8);
      for (let i = 0; i < ROW; i++) out[i] += scale * w[k] * rows[from + 4 * i];
    }
    return out;
  }

  /* The lamps' own coefficients at a place; nothing in a lamp. */
  function exactAt(x) {
    const out = new Float64Array(ROW);
    for (const l of lamps) {
      if (!lightOf(l, ...x)) return null;
      channelsOf(l).forEach((e, c) => { for (let k = 0; k < COUNT; k++) out[c * COUNT + k] += e * NUMBERS[4 * k]; });
    }
    return out;
  }

  const short = x => Number.isFinite(x) ? x.toPrecision(4) : 'unknown';

  /* Which part of a leaf with sides answers. */
  function partWords(found) {
    const from = sections.cells[12 * found.leaf];
    if (found.whole < meta.counts.cells) return [];
    return [`part ${found.whole - sections.sides[from] + 1} of ${sections.sides[from + 1]}`];
  }

  /* Says what the grid knows at the surface under a pixel, and draws the cell. */
  function ask(x, y) {
    chosen = null;
    $('corner').textContent = '';
    const ray = rayAt(x, y), hit = mesh && hitAlong(state.from, ray);
    if (!hit || hit.distance === Infinity) return;
    const place = plus(state.from, ray, hit.distance), found = locate(place, hit.normal), words = ['at ' + place.map(c => +c.toFixed(6)).join(' ')];
    if (found.leaf >= 0 && found.whole >= 0) {
      const c = cellAt(found.leaf), L = sample(found), lo = placeOf(c.origin), corners = [];
      const edge = meta.unit.map(u => u * c.edge);
      words.push(`cell ${found.leaf + 1}, level ${c.level}, ${edge.map(short).join(' x ')}`,
        'estimated error ' + short(halfTable[sections.cells[12 * found.leaf + 3] >>> 16]),
        ...partWords(found), 'L00 ' + [...Array(meta.channels)].map((_, k) => short(L[k * COUNT])).join(' '));
      const E = meta.no_exact ? null : exactAt(place);
      if (E) {
        let square = 0, all = 0;
        for (let i = 0; i < ROW; i++) { square += (L[i] - E[i]) ** 2; all += E[i] ** 2; }
        words.push('of the lamps ' + [...Array(meta.channels)].map((_, k) => short(E[k * COUNT])).join(' '),
          'true error ' + short(Math.sqrt(square / all)));
      }
      for (let k = 0; k < 8; k++) corners.push(sections.cells[12 * found.whole + 4 + k]);
      chosen = { box: lines(boxOf(lo, edge)), corners: corners, size: Math.min(...edge), lobes: null };
    } else words.push('no cell has light there');
    $('corner').textContent = words.join('\n');
  }

  function boxOf(lo, edge) {
    const out = [], yellow = [1, 0.85, 0.2];
    for (let a = 0; a < 3; a++) {
      for (let k = 0; k < 4; k++) {
        const from = lo.slice();
        from[(a + 1) % 3] += (k & 1) * edge[(a + 1) % 3];
        from[(a + 2) % 3] += (k >> 1) * edge[(a + 2) % 3];
        const to = from.slice();
        to[a] += edge[a];
        out.push(...from, ...to, ...yellow);
      }
    }
    return out;
  }

  function nearer(factor) { state.from = plus(state.at, sub(state.from, state.at), factor); }

  const pointers = new Map();
  let pressed = null;  /* where a pointer went down that has not moved since */

  function listen() {
    canvas.addEventListener('pointerdown', e => {
      canvas.setPointerCapture(e.pointerId);
      pointers.set(e.pointerId, [e.clientX, e.clientY]);
      pressed = [e.clientX, e.clientY];
      const lamp = e.button === 0 && pointers.size === 1 ? lampAt(e.clientX, e.clientY, 6) : -1;
      if (lamp >= 0) takeLamp(lamp, e.clientX, e.clientY);
    });
    canvas.addEventListener('pointermove', e => {
      const before = pointers.get(e.pointerId);
      if (!before) {
        canvas.style.cursor = lampAt(e.clientX, e.clientY, 6) >= 0 ? 'grab' : '';
        return;
      }
      if (grip && pointers.size === 1) {
        dragLamp(e.clientX, e.clientY, e.shiftKey);
        pointers.set(e.pointerId, [e.clientX, e.clientY]);
        return change(true);
      }
      if (pressed && Math.hypot(e.clientX - pressed[0], e.clientY - pressed[1]) < 3) return;
      pressed = null;
      const dx = e.clientX - before[0], dy = e.clientY - before[1];
      if (pointers.size === 2) {
        const other = [...pointers.entries()].find(([id]) => id !== e.pointerId)[1];
        const was = Math.hypot(before[0] - other[0], before[1] - other[1]);
        const is = Math.hypot(e.clientX - other[0], e.clientY - other[1]);
        if (was > 0 && is > 0) nearer(was / is);
        shift(dx / 2, dy / 2);
      } else if (e.buttons & 2 || e.shiftKey) shift(dx, dy);
      else turn(dx, dy);
      pointers.set(e.pointerId, [e.clientX, e.clientY]);
      change(true);
    });
    for (const name of ['pointerup', 'pointercancel'])
      canvas.addEventListener(name, e => {
        pointers.delete(e.pointerId);
        if (grip) look();
        else if (pressed && name === 'pointerup' && e.button === 0) {
          ask(e.clientX, e.clientY);
          change(false);
        }
        grip = pressed = null;
      });
    canvas.addEventListener('wheel', e => {
      e.preventDefault();
      nearer(Math.exp(Math.max(-300, Math.min(300, e.deltaY)) * 1e-3));
      change(true);
    }, { passive: false });
    canvas.addEventListener('contextmenu', e => e.preventDefault());
    window.addEventListener('resize', () => change(false));
    window.addEventListener('keydown', e => {
      if (e.ctrlKey || e.altKey || e.metaKey) return;
      const a = actions.find(x => x.key === e.key || (x.key === '+' && e.key === '='));
      if (a) { a.run(); e.preventDefault(); }
    });
    window.addEventListener('hashchange', () => { obey(); look(); change(false); });
    canvas.addEventListener('webglcontextlost', e => {
      e.preventDefault();
      fail('The graphics driver has taken the picture away: load the page again.');
    });
  }

  /* What the address asks for behind #, mode=error&lines&ev=1&from=2,1,3; what it leaves out is as it was at first. */
  function obey() {
    const words = new URLSearchParams(location.hash.slice(1));
    const three = name => {
      const x = (words.get(name) || '').split(',').map(Number);
      return x.length === 3 && x.every(Number.isFinite) ? x : null;
    };
    const number = (name, least, most) => {
      const x = words.has(name) ? Number(words.get(name)) : NaN;
      return x >= least && x <= most ? x : null;
    };
    const mode = words.get('mode');
    home();
    state.mode = mode in MODES && mode !== 'depth' && !lacks(mode) ? mode : meta.mesh ? FIRST : 'levels';
    state.lines = words.has('lines') || !meta.mesh;
    state.lamps = !words.has('nolamps');
    state.lobes = words.has('lobes');
    dropLobes();
    const exposure = number('ev', -20, 20), fov = number('fov', 1, 179);
    state.exposure = exposure !== null ? exposure : meta.exposure;
    if (fov !== null) state.fov = fov;
    state.samples = words.get('samples') === '1' ? 1 : 4;
    state.tone = TONES.includes(words.get('tone')) ? words.get('tone') : meta.tone;
    const from = three('from'), at = three('at');
    if (from && Math.hypot(...sub(from, at || state.at)) > 0) state.from = from;
    if (at && Math.hypot(...sub(at, state.from)) > 0) state.at = at;
    state.still = words.has('still');
    document.body.classList.toggle('bare', words.has('bare'));
  }

  /* ---- beginning ------------------------------------------------------------------ */

  /* Why this browser cannot draw the page; nothing where it can. */
  function missing() {
    if (typeof DecompressionStream === 'undefined' && meta.sections.some(s => s.coding.includes('zlib')))
      return 'This page needs a browser that inflates data (DecompressionStream: Chrome 80, Firefox 113, Safari 16.4).';
    gl = canvas.getContext('webgl2', { antialias: false, alpha: false, depth: false, powerPreference: 'high-performance' });
    if (!gl) return 'This page needs WebGL 2: switch hardware acceleration on, or take another browser.';
    if (!gl.getExtension('EXT_color_buffer_float') && !gl.getExtension('EXT_color_buffer_half_float'))
      return 'This page needs WebGL 2 that draws float pictures (EXT_color_buffer_float).';
    const least = Math.max(WIDE, Math.ceil(meta.counts.points * ROW / WIDE));
    if (gl.getParameter(gl.MAX_TEXTURE_SIZE) < least) return `This page needs textures of ${least} texels a side.`;
  }

  /* Decodes a grid in few bytes. */
  async function readFew() {
    let last = performance.now();
    const made = await decodeFew(meta, sections, async share => {
      if (performance.now() - last < SLICE) return;
      tell(`reading the grid, ${Math.round(100 * share)} %`);
      warm();
      await breath();
      last = performance.now();
    });
    fewCells(sections.cells, made.layout, made.place);
    if (meta.sides) sections.sides = fewSides(made.layout, meta.counts.cells);
    sections.data = made.data;
    sections.flags = made.flags;
  }

  async function begin() {
    root.dataset.state = 'loading';
    const why = missing();
    if (why) return fail(why);
    tell('reading the grid');
    obey();
    if (meta.mesh) {
      bufferProgram();
      surfaceProgram(state.mode);
    }
    if (state.lamps && lamps.length) lampProgram();
    resolveProgram();
    resize();
    making = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    sections = await readSections();
    mesh = makeMesh();
    if (meta.light) makeProbes(readProbes(sections.probes.slice().buffer));
    warm();
    if (mesh && state.mode === 'scene' && !state.lines && !state.lobes) await showScene();
    if (meta.precision === 'few') await readFew();
    rows = rowsOf(sections);
    born = births(sections.cells);
    places = placesOf(sections.cells);
    await continueRows(rows, sections.cells, born, share => {
      tell(`points of continuity, ${Math.round(100 * share)} %`);
      warm();
    });
    makeTextures();
    makeBar();
    listen();
    look();
    tell('the first picture');
    await breath();
    change(false);
  }

  window.addEventListener('error', e => fail('This page failed: ' + e.message));
  begin().catch(error => fail('This page cannot be shown: ' + error.message));
})();
