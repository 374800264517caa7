/* Grids in few bytes, as csrc/grid/small/ writes them. Functions stand in the order of its files: coder.c,
   layout.c, row.c, stream.c and rans.h, decode.c. Numbers that are floats there are rounded to floats here, one operation
   after another, so that decoded rows are the same bits. A stream that is damaged throws. */

const FEW = /*@CONSTANTS@*/{};  /* those of csrc/grid/small/, by the library */
FEW.SUM = 1 << FEW.BITS;
FEW.SIDE = 2 + FEW.PIECES / 8;  /* words of a leaf with sides */
const float = Math.fround;

function damagedFew(what) { throw new Error('the grid is damaged: ' + what); }

/* n estimates of a bit: the quick one and the slow one, in turn. */
const chances = n => new Uint16Array(2 * n).fill(FEW.EVEN);

/* Bits with adaptive chances. An estimate is named by its list and its place there. */
function fewCoder(bytes) {
  let at = 0, code = 0, range = 0xffffffff, short = 0;
  const next = () => at < bytes.length ? bytes[at++] : (short++, 0);
  for (let i = 0; i < 4; i++) code = (code << 8 | next()) >>> 0;

  function bitBy(zero) {
    const bound = (range >>> 16) * Math.min(Math.max(zero, FEW.LEAST), 65536 - FEW.LEAST), bit = code >= bound ? 1 : 0;
    if (bit) { range -= bound; code -= bound; } else range = bound;
    while (range < FEW.TOP) {
      range = range * 256;
      code = (code << 8 | next()) >>> 0;
    }
    return bit;
  }
  function learn(p, i, bit) {
    if (bit) {
      p[i] -= p[i] >> FEW.QUICK;
      p[i + 1] -= p[i + 1] >> FEW.SLOW;
    } else {
      p[i] += 65535 - p[i] >> FEW.QUICK;
      p[i + 1] += 65535 - p[i + 1] >> FEW.SLOW;
    }
  }
  function bit(p, i) {
    const b = bitBy(p[2 * i] + p[2 * i + 1] >> 1);
    learn(p, 2 * i, b);
    return b;
  }
  function bitOf(p, i, q, j) {
    const b = bitBy(p[2 * i] + p[2 * i + 1] + q[2 * j] + q[2 * j + 1] >> 2);
    learn(p, 2 * i, b);
    learn(q, 2 * j, b);
    return b;
  }
  function symbol(p, from, n) {
    let node = 1;
    for (let i = 0; i < n; i++) node = 2 * node + bit(p, from + node);
    return node - (1 << n);
  }
  function symbolOf(p, from, q, other, n) {
    let node = 1;
    for (let i = 0; i < n; i++) node = 2 * node + bitOf(p, from + node, q, other + node);
    return node - (1 << n);
  }
  function number(p, from) {
    const bits = Math.min(symbol(p, from, 5), 30);
    let out = 1;
    if (bits) out = 2 + bit(p, from + 32 + bits);
    for (let i = 1; i < bits; i++) out = 2 * out + bitBy(FEW.EVEN);
    return out - 1;
  }
  function signed(p, from) {
    const folded = number(p, from), half = Math.floor(folded / 2);
    return folded % 2 ? -half - 1 : half;
  }
  function raw(n) {
    let out = 0;
    for (let i = 0; i < n; i++) out = 2 * out + bitBy(FEW.EVEN);
    return out;
  }
  return { bit, symbol, symbolOf, number, signed, raw, isShort: () => short > 0 };
}

/* ---- cells and points ------------------------------------------------------ */

const placeKey = (x, y, z) => (z * 65537 + y) * 65537 + x;

/* Cells and points, in the order in which points are coded; facts: of the page, head: of the file. */
function layOutFew(facts, head, bytes) {
  const cells = facts.counts.octree, points = facts.counts.evaluated, lattice = facts.kind === 'uniform', deepest = facts.depth;
  const coder = fewCoder(bytes), known = new Map(), chance = { split: chances(4 * 17), occupied: chances(8), data: chances(8),
    crossed: chances(8), sided: chances(4), brick: chances(2), centre: chances(17), gap: chances(64), loose: chances(3 * 64),
    parts: chances(16), piece: chances(3 * 17), label: chances(16), ghost: chances(3), fresh: chances(2), back: chances(64),
    near: chances(1 << FEW.NEAR_BITS) };
  const c = { cells: 0, level: new Uint8Array(cells), flags: new Uint8Array(cells), child: new Uint32Array(cells),
    parent: new Uint32Array(cells).fill(FEW.NONE), origin: new Uint32Array(3 * cells),
    corner: new Uint32Array(8 * cells).fill(FEW.NONE) };
  let p = { met: 0, at: new Uint32Array(3 * points), level: new Uint8Array(points),
    parent: new Uint32Array(FEW.PARENTS * points).fill(FEW.NONE), kin: new Uint32Array(points).fill(FEW.NONE),
    corner: new Uint8Array(points), ghost: new Uint8Array(points) };
  const sides = { cell: [], first: [], pieces: [], node: [], leaf: [] };  /* node: of eight corners a part; leaf: of parts */
  const ghosts = new Map(), ghostBefore = new Map();  /* the last ghost at a corner, and that before each */
  const edgeOf = i => lattice ? 1 : 2 ** (deepest - c.level[i]);
  const isComplete = i => !c.corner.subarray(8 * i, 8 * i + 8).includes(FEW.NONE);

  function pointAt(x, y, z, level) {
    const key = placeKey(x, y, z), i = known.get(key);
    if (i !== undefined) return i;
    known.set(key, p.met);
    return meet(x, y, z, level);
  }
  function meet(x, y, z, level) {
    const i = p.met++;
    if (i >= points) damagedFew('its number of points');
    p.at.set([x, y, z], 3 * i);
    p.level[i] = level;
    return i;
  }
  function addParent(point, cell) {
    for (let i = FEW.PARENTS * point; i < FEW.PARENTS * (point + 1); i++) {
      if (p.parent[i] === cell) return;
      if (p.parent[i] !== FEW.NONE) continue;
      p.parent[i] = cell;
      return;
    }
  }
  function bringCorners(i) {
    const edge = edgeOf(i), above = c.parent[i] !== FEW.NONE && isComplete(c.parent[i]), o = c.origin.subarray(3 * i, 3 * i + 3);
    for (let k = 0; k < 8; k++) {
      const point = pointAt(o[0] + (k & 1) * edge, o[1] + (k >> 1 & 1) * edge, o[2] + (k >> 2) * edge, c.level[i]);
      c.corner[8 * i + k] = point;
      if (p.level[point] !== c.level[i]) continue;
      if (above) addParent(point, c.parent[i]);
      if (p.kin[point] === FEW.NONE) {
        p.kin[point] = i;
        p.corner[point] = k;
      }
    }
  }
  function bringCentre(i) {
    const half = edgeOf(i) / 2, o = c.origin.subarray(3 * i, 3 * i + 3);
    addParent(pointAt(o[0] + half, o[1] + half, o[2] + half, c.level[i] + 1), i);
  }
  function piecesOf() {
    const part = new Uint8Array(FEW.PIECES), step = [1, FEW.ACROSS, FEW.ACROSS * FEW.ACROSS];
    for (let i = 0; i < FEW.PIECES; i++) {
      const beside = [...new Set(step.filter(d => Math.floor(i / d) % FEW.ACROSS).map(d => part[i - d]))], n = beside.length;
      const found = beside.findIndex((_, m) => coder.bit(chance.piece, 17 * m + 4 * n + i % 2));
      part[i] = found >= 0 ? beside[found] : coder.symbol(chance.label, 0, 4);
    }
    return part;
  }
  /* Reads over the place where the field was asked for a ghost. */
  function skipAsked(hasPieces) {
    if (hasPieces && coder.bit(chance.fresh, 1)) {
      coder.symbol(chance.near, 0, FEW.NEAR_BITS);
      coder.raw(FEW.WAY_BITS);
    } else coder.raw(3 * FEW.ASKED_BITS);
  }
  function ghostAt(x, y, z, level, hasPieces) {
    const key = placeKey(x, y, z), last = ghosts.get(key);
    if (last !== undefined && !coder.bit(chance.fresh, 0)) {
      let found = last;
      for (let back = coder.number(chance.back, 0); back && found !== undefined; back--) found = ghostBefore.get(found);
      if (found === undefined) damagedFew('its ghosts');
      return found;
    }
    const i = meet(x, y, z, level);
    p.ghost[i] = 1;
    ghostBefore.set(i, last);
    ghosts.set(key, i);
    skipAsked(hasPieces);
    return i;
  }
  /* A leaf that surfaces cross: the parts of its pieces, and their corners. */
  function bringSide(i) {
    const parts = coder.symbol(chance.parts, 0, 4), pieces = piecesOf(), first = sides.leaf.length, edge = edgeOf(i);
    sides.cell.push(i);
    sides.first.push(first);
    sides.pieces.push(pieces);
    for (let part = 0; part < parts; part++) {
      const hasPieces = pieces.includes(part), corner = [];
      for (let k = 0; k < 8; k++) {
        const at = [0, 1, 2].map(a => c.origin[3 * i + a] + (k >> a & 1) * edge);
        const isGhost = coder.bit(chance.ghost, k ? 1 + p.ghost[corner[k - 1]] : 0);
        const point = corner[k] = isGhost ? ghostAt(...at, c.level[i], hasPieces) : pointAt(...at, c.level[i]);
        if (p.kin[point] !== FEW.NONE) continue;
        p.kin[point] = cells + first + part;
        p.corner[point] = k;
      }
      sides.node.push(...corner);
      sides.leaf.push(i);
    }
    if (parts) c.corner.set(sides.node.slice(8 * first, 8 * first + 8), 8 * i);
  }
  function split(i) {
    const half = edgeOf(i) / 2, first = c.cells;
    c.child[i] = first;
    c.cells += 8;
    if (c.cells > cells) damagedFew('its number of cells');
    for (let k = 0; k < 8; k++) {
      c.level[first + k] = c.level[i] + 1;
      c.parent[first + k] = i;
      for (let a = 0; a < 3; a++) c.origin[3 * (first + k) + a] = c.origin[3 * i + a] + (k >> a & 1) * half;
    }
  }
  function visit(i) {
    const above = c.parent[i] === FEW.NONE ? 0 : c.flags[c.parent[i]], beside = i ? c.flags[i - 1] : 0;
    const deeper = !lattice && c.level[i] < deepest, busy = beside & FEW.OCCUPIED ? 1 : 0, last = i && !(beside & FEW.LEAF) ? 1 : 0;
    const isSplit = deeper ? coder.bit(chance.split, 4 * c.level[i] + 2 * last + busy) : 0;
    let flags = isSplit ? 0 : FEW.LEAF;
    if (coder.bit(chance.occupied, 4 * isSplit + 2 * busy + (above & FEW.OCCUPIED ? 1 : 0))) flags |= FEW.OCCUPIED;
    const crossed = 2 * (beside & FEW.CROSSED ? 1 : 0) + (above & FEW.CROSSED ? 1 : 0);
    if (coder.bit(chance.crossed, 4 * isSplit + crossed)) flags |= FEW.CROSSED;
    if (!isSplit && facts.sides && coder.bit(chance.sided, 2 * (flags & FEW.OCCUPIED ? 1 : 0) + (beside & FEW.SIDED ? 1 : 0)))
      flags |= FEW.SIDED;
    if (!isSplit && !lattice && coder.bit(chance.brick, 0)) flags |= FEW.BRICK;
    c.flags[i] = flags;
    const data = !(flags & FEW.SIDED) && coder.bit(chance.data, 4 * isSplit + 2 * (flags & FEW.OCCUPIED ? 1 : 0) + busy);
    const centre = data && !isSplit && deeper && !facts.sides && coder.bit(chance.centre, c.level[i]);
    if (data) bringCorners(i);
    if (flags & FEW.SIDED) bringSide(i);
    if (centre) bringCentre(i);
    if (isSplit) split(i);
    if (coder.isShort()) damagedFew('its octree ends early');
  }
  function visitVoxels() {
    const r = facts.resolution;
    for (let i = 0, next = 0; i < cells; i++, next++) {
      next += coder.number(chance.gap, 0);
      if (next >= r[0] * r[1] * r[2]) damagedFew('its voxels');
      c.origin.set([next % r[0], Math.floor(next / r[0]) % r[1], Math.floor(next / r[0] / r[1])], 3 * i);
      c.cells++;
      visit(i);
    }
  }
  function visitOctree() {
    c.level[0] = facts.root[3];
    c.origin.set(facts.root.slice(0, 3));
    c.cells = 1;
    for (let i = 0; i < c.cells; i++) visit(i);
    for (let i = 0; i < head.loose; i++) {
      const at = [0, 1, 2].map(a => facts.root[a] + coder.number(chance.loose, 64 * a));
      if (coder.isShort() || at.some((x, a) => x > facts.resolution[a])) damagedFew('its loose points');
      pointAt(...at, FEW.LOOSE);
    }
  }
  if (lattice) visitVoxels();
  else visitOctree();
  if (c.cells !== cells || p.met !== points) damagedFew('its counts');

  /* Of how many axes a point is in the middle of its parent's edges. */
  function middlesOf(i) {
    const parent = p.parent[FEW.PARENTS * i];
    if (parent === FEW.NONE) return 0;
    let n = 0;
    for (let a = 0; a < 3; a++) n += p.at[3 * i + a] - c.origin[3 * parent + a] === edgeOf(parent) / 2 ? 1 : 0;
    return n;
  }
  /* Points by levels; of a level those in the middle of edges first, then of faces, then of cells. */
  function sorted() {
    const rank = Array.from({ length: points }, (_, i) => 4 * p.level[i] + middlesOf(i));
    const order = Uint32Array.from(rank.keys()).sort((a, b) => rank[a] - rank[b] || a - b);
    const q = { met: points, at: new Uint32Array(3 * points), level: p.level.slice(), parent: p.parent.slice(), kin: p.kin.slice(),
      corner: p.corner.slice(), ghost: p.ghost.slice(), before: order };
    order.forEach((was, to) => {
      if (!p.ghost[was]) known.set(placeKey(p.at[3 * was], p.at[3 * was + 1], p.at[3 * was + 2]), to);
      q.ghost[to] = p.ghost[was];
      q.at.set(p.at.subarray(3 * was, 3 * was + 3), 3 * to);
      q.parent.set(p.parent.subarray(FEW.PARENTS * was, FEW.PARENTS * (was + 1)), FEW.PARENTS * to);
      q.level[to] = p.level[was];
      q.kin[to] = p.kin[was];
      q.corner[to] = p.corner[was];
    });
    return q;
  }
  const find = (x, y, z) => { const i = known.get(placeKey(x, y, z)); return i === undefined ? FEW.NONE : i; };
  p = sorted();
  const rank = new Uint32Array(points), node = Uint32Array.from(sides.node);
  const endOf = n => n + 1 < sides.first.length ? sides.first[n + 1] : sides.leaf.length;  /* behind the parts of a side */
  p.before.forEach((was, to) => { rank[was] = to; });
  for (let i = 0; i < node.length; i++) node[i] = rank[node[i]];
  sides.cell.forEach((i, n) => {
    const first = 8 * sides.first[n];
    if (first < 8 * endOf(n)) c.corner.set(node.subarray(first, first + 8), 8 * i);
  });
  for (let i = 0; i < cells; i++) {
    const edge = edgeOf(i), o = c.origin.subarray(3 * i, 3 * i + 3), isSided = c.flags[i] & FEW.SIDED;
    for (let k = 0; k < 8 && !isSided; k++)
      c.corner[8 * i + k] = find(o[0] + (k & 1) * edge, o[1] + (k >> 1 & 1) * edge, o[2] + (k >> 2) * edge);
    if (isComplete(i)) c.flags[i] |= FEW.BAKED;
    else if (facts.sides && !isSided) c.corner.fill(FEW.NONE, 8 * i, 8 * i + 8);
  }
  /* The corners of a cell, or, from `cells` on, of a part. */
  const cornersOf = i => i < cells ? c.corner.subarray(8 * i, 8 * i + 8) : node.subarray(8 * (i - cells), 8 * (i - cells) + 8);
  return { cells: c, points: p, sides, endOf, cornersOf, edgeOf, find };
}

/* ---- predictions, steps, turns --------------------------------------------- */

/* n columns of n entries become orthonormal. */
function orthonormal(entry, column, n) {
  for (let k = 0; k < n; k++) {
    const x = Array.from(entry.subarray(k * n, (k + 1) * n), e => e / 127);
    for (let axis = 0; ; axis++) {
      let sum = 0;
      for (let m = 0; m < k; m++) {
        let dot = 0;
        for (let i = 0; i < n; i++) dot += x[i] * column[m * n + i];
        for (let i = 0; i < n; i++) x[i] -= dot * column[m * n + i];
      }
      for (let i = 0; i < n; i++) sum += x[i] * x[i];
      if (sum > 1e-4) {
        const inverse = 1 / Math.sqrt(sum);
        for (let i = 0; i < n; i++) column[k * n + i] = x[i] * inverse;
        break;
      }
      for (let i = 0; i < n; i++) x[i] = i === (k + axis) % n ? 1 : 0;
      if (axis > 2 * n) {
        column.set(x, k * n);
        break;
      }
    }
  }
}

/* The turn of a block's colours, by columns: a unit quaternion without its largest number. */
function colourTurn(turn, column) {
  const q = [0, 0, 0, 0], largest = turn >>> 30;
  let sum = 0, bits = turn;
  for (let i = 0; i < 4; i++) {
    if (i === largest) continue;
    q[i] = ((bits & 1023) - FEW.TURN_MOST) / FEW.TURN_MOST * 0.70710678118654752;
    sum += q[i] * q[i];
    bits >>>= 10;
  }
  q[largest] = sum < 1 ? Math.sqrt(1 - sum) : 0;
  const scale = sum < 1 ? 1 : 1 / Math.sqrt(sum), [w, x, y, z] = q.map(t => t * scale);
  column.set([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y),
    2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x),
    2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]);
}

const scratch64 = new Float64Array(1), words64 = new Uint32Array(scratch64.buffer);

/* The exponent e of the power of 2 that is nearest to a number by its logarithm. */
function exponentOf(x) {
  scratch64[0] = x;
  const e = (words64[1] >>> 20) - 1022;
  words64[1] = (words64[1] & 0xfffff) | 1022 << 20;
  return scratch64[0] < 0.70710678118654752 ? e - 1 : e;
}

/* Decodes rows of points: data [points][rows][width]. */
function fewFrame(facts, head, layout, bases, frame) {
  const { cells, points, cornersOf, edgeOf, find } = layout, n = points.met, lattice = facts.kind === 'uniform';
  const rows = facts.sides ? 1 : 4;  /* values, and slopes where there are no sides */
  const count = (facts.lmax + 1) * (facts.lmax + 1), channels = facts.channels, width = channels * count, record = rows * width;
  const data = new Float32Array(n * record), numbers = new DataView(frame.buffer, frame.byteOffset);
  if (frame.length !== 8 * (4 + facts.lmax)) damagedFew('its frame');
  const voxel = [0, 1, 2].map(a => numbers.getFloat64(8 * a, true)), depth = lattice ? 0 : facts.depth;
  const weight = new Float32Array(count), unweight = new Float32Array(count), edge = new Uint8Array(n).fill(255);
  for (let l = 0; l <= facts.lmax; l++) {
    const w = Math.max(Math.abs(float(numbers.getFloat64(8 * (3 + l), true))), head.degree);
    weight.fill(w, l * l, (l + 1) * (l + 1));
    unweight.fill(1 / float(w), l * l, (l + 1) * (l + 1));
  }
  for (let i = 0; i < cells.cells; i++) {
    if (!(cells.flags[i] & FEW.LEAF)) continue;
    for (let k = 0; k < 8; k++) {
      const p = cells.corner[8 * i + k];
      if (p < n) edge[p] = Math.min(edge[p], cells.level[i]);
    }
  }
  for (let i = 0; i < n; i++) edge[i] = Math.min(edge[i] === 255 ? points.level[i] : edge[i], depth);

  /* Turns of coefficients and of colours. */
  const degrees = head.turn === 2 ? [[0, count]] : head.turn === 1 ? Array.from({ length: facts.lmax + 1 }, (_, l) => [l * l, 2 * l + 1]) : [];
  const size = degrees.reduce((sum, d) => sum + d[1] * d[1], 0), blocks = channels === 3 ? Math.ceil(n / FEW.BLOCK) : 0;
  if (bases.length !== rows * size + 4 * blocks) damagedFew('its bases');
  const entries = new Int8Array(bases.buffer, bases.byteOffset, rows * size), columns = new Float32Array(rows * size);
  for (let r = 0, at = 0; r < rows; r++)
    for (const [, m] of degrees) {
      orthonormal(entries.subarray(at, at + m * m), columns.subarray(at, at + m * m), m);
      at += m * m;
    }
  const turns = new DataView(bases.buffer, bases.byteOffset + rows * size), colour = new Float32Array(9 * blocks);
  for (let i = 0; i < blocks; i++) colourTurn(turns.getUint32(4 * i, true), colour.subarray(9 * i, 9 * i + 9));

  /* Adds weight * row r of a point, one float after another: where data are stored, they are rounded. */
  function addRow(to, point, r, w) {
    for (let i = 0, j = point * record + r * width; i < width; i++) data[to + i] += float(w * data[j + i]);
  }
  /* Four of these at once: where rows begin, and their weights. */
  const begins = new Int32Array(128), by = new Float32Array(128);
  function addFour(to, k) {
    const a = begins[k], b = begins[k + 1], c = begins[k + 2], d = begins[k + 3];
    const wa = by[k], wb = by[k + 1], wc = by[k + 2], wd = by[k + 3];
    for (let i = 0; i < width; i++) {
      let x = data[to + i];
      x = float(x + float(wa * data[a + i]));
      x = float(x + float(wb * data[b + i]));
      x = float(x + float(wc * data[c + i]));
      data[to + i] = float(x + float(wd * data[d + i]));
    }
  }
  let terms = 0;
  function addTerm(point, r, weight) {
    begins[terms] = point * record + r * width;
    by[terms++] = weight;
  }
  function addTerms(to) {
    let k = 0;
    for (; k + 4 <= terms; k += 4) addFour(to, k);
    for (; k < terms; k++) for (let i = 0, x = by[k], from = begins[k]; i < width; i++) data[to + i] += float(x * data[from + i]);
    terms = 0;
  }
  function scaleRows(to, n, scale) {
    for (let i = to; scale !== 1 && i < to + n; i++) data[i] *= scale;
  }

  /* Terms of the value and slopes at place 0 .. 26 of a cell of a level: corners, their rows, weights in turn. */
  const recipes = new Map();
  function recipeOf(level, place) {
    const key = 27 * level + place;
    if (recipes.has(key)) return recipes.get(key);
    const rounded = f => { for (const name of ['l', 's', 'k']) f[name] = f[name].map(float); return f; };
    const value = [], slope = [], lists = [], w = new Array(32);
    for (let a = 0, rest = place; a < 3; a++, rest = Math.floor(rest / 3)) {
      const long = float(voxel[a] * 2 ** (depth - level));
      value.push(rounded(values(rest % 3 / 2, long)));
      slope.push(rounded(slopes(rest % 3 / 2, long)));
    }
    for (let r = 0; r < rows; r++) {
      const list = [];
      corner_weights(w, ...value.map((f, a) => a === r - 1 ? slope[a] : f));
      w.forEach((x, k) => { if (float(x) !== 0) list.push(k & 7, k >> 3, float(x)); });
      lists.push(list);
    }
    recipes.set(key, lists);
    return lists;
  }

  /* Points before and behind a point along each axis, at a half of its parent's edges, and how far these are; NONE: no pair. */
  const low = new Uint32Array(3), high = new Uint32Array(3), apart = new Float32Array(3);
  function findPairs(met) {
    const parent = points.parent[FEW.PARENTS * met], half = edgeOf(parent) / 2, at = 3 * met;
    const x = points.at[at], y = points.at[at + 1], z = points.at[at + 2];
    let middles = 0, pairs = 0;
    for (let a = 0; a < 3; a++) middles += points.at[at + a] - cells.origin[3 * parent + a] === half ? 1 : 0;
    for (let a = 0; a < 3; a++) {
      low[a] = FEW.NONE;
      if (middles < 2 || points.at[at + a] - cells.origin[3 * parent + a] !== half) continue;
      const dx = a === 0 ? half : 0, dy = a === 1 ? half : 0, dz = a === 2 ? half : 0;
      const p = find(x - dx, y - dy, z - dz), q = find(x + dx, y + dy, z + dz);
      if (p >= met || q >= met) continue;
      low[a] = p;
      high[a] = q;
      apart[a] = voxel[a] * (2 * half);
      pairs++;
    }
    return pairs;
  }
  /* One row, from pairs: the cubic between two points says their middle's value and its slope along the axis; other slopes are
     means. */
  function mixPairs(pairs, r, to) {
    if (r && low[r - 1] !== FEW.NONE) {
      const w = float(1.5 / apart[r - 1]);
      addTerm(high[r - 1], 0, w);
      addTerm(low[r - 1], 0, -w);
      addTerm(high[r - 1], r, -0.25);
      addTerm(low[r - 1], r, -0.25);
      return addTerms(to);
    }
    for (let a = 0; a < 3; a++) {
      if (low[a] === FEW.NONE) continue;
      addTerm(low[a], r, 0.5);
      addTerm(high[a], r, 0.5);
      if (r || rows === 1) continue;
      addTerm(low[a], a + 1, 0.125 * apart[a]);
      addTerm(high[a], a + 1, -0.125 * apart[a]);
    }
    addTerms(to);
    scaleRows(to, width, float(1 / pairs));
  }
  function placeIn(cell, met) {
    const half = edgeOf(cell) / 2;
    let place = 0;
    for (let a = 2; a >= 0; a--) place = 3 * place + Math.floor((points.at[3 * met + a] - cells.origin[3 * cell + a]) / half);
    return place;
  }
  function byParents(met, to) {
    const pairs = findPairs(met);
    for (let r = 0; pairs && r < rows; r++) mixPairs(pairs, r, to + r * width);
    if (pairs) return;
    let parents = 0;
    while (parents < FEW.PARENTS && points.parent[FEW.PARENTS * met + parents] !== FEW.NONE) parents++;
    for (let r = 0; r < rows; r++) {
      for (let p = 0; p < parents; p++) {
        const cell = points.parent[FEW.PARENTS * met + p], list = recipeOf(cells.level[cell], placeIn(cell, met))[r];
        for (let k = 0; k < list.length; k += 3) addTerm(cells.corner[8 * cell + list[k]], list[k + 1], list[k + 2]);
      }
      addTerms(to + r * width);
    }
    scaleRows(to, record, float(1 / parents));
  }
  function byKin(met, to) {
    const cell = points.kin[met], own = points.corner[met], corner = cornersOf(cell);
    let known = 0;
    for (let a = 0; a < 3; a++) {
      const p = corner[own ^ 1 << a];
      if (p >= met) continue;
      known++;
      for (let r = 0; r < rows; r++) addRow(to + r * width, p, r, 1);
      if (rows === 1) continue;
      const way = float(voxel[a] * edgeOf(cell));
      addRow(to, p, a + 1, own >> a & 1 ? way : -way);
    }
    for (let k = 0; !known && k < 8; k++) {
      if (corner[k] >= met) continue;
      for (let r = 0; r < rows; r++) addRow(to + r * width, corner[k], r, 1);
      return;
    }
    scaleRows(to, record, float(1 / known));
  }

  /* Bits 1: a point can be predicted by parents, 2: by kin. */
  function ways(met) {
    const cell = points.kin[met], hasParent = points.parent[FEW.PARENTS * met] !== FEW.NONE ? 1 : 0;
    if (hasParent && rows > 1 || cell === FEW.NONE) return hasParent;
    return hasParent | (cornersOf(cell).some(p => p < met) ? 2 : 0);
  }
  function predict(met, way) {
    if (way === 1) byParents(met, met * record);
    if (way === 2) byKin(met, met * record);
  }
  const least = head.least * head.least, most = head.most * head.most;
  function exponent(met) {
    let sum = 0;
    for (let i = 0, j = met * record; i < width; i++, j++) {
      const x = data[j] * weight[i % count];
      sum += x * x;
    }
    return exponentOf(sum >= least ? sum <= most ? sum : most : least);
  }
  function steps(met, e) {
    const whole = 2 ** ((e - (e & 1)) / 2), step = [float(head.step * (e & 1 ? float(whole * float(1.41421356)) : whole))];
    for (let a = 0; a < 3; a++) step.push(float(float(head.slopes * step[0]) / (voxel[a] * 2 ** (depth - edge[met]))));
    return step;
  }

  /* Numbers [rows][width] are turned back and added. */
  const room = new Float32Array(width);
  function turnBack(number, r, c) {
    const to = c * count, first = r * width + to;
    if (!degrees.length) return room.set(number.subarray(first, first + count), to);
    room.fill(0, to, to + count);
    let at = r * size;
    for (const [begin, m] of degrees)
      for (let k = 0; k < m; k++, at += m) {
        const x = number[first + begin + k];
        for (let i = 0; x !== 0 && i < m; i++) room[to + begin + i] += float(x * columns[at + i]);
      }
  }
  function add(met, step, number, used) {
    const v = blocks ? 9 * Math.floor(points.before[met] / FEW.BLOCK) : 0;
    for (let r = 0; r < rows; r++) {
      if (!used[r]) continue;
      for (let c = 0; c < channels; c++) turnBack(number, r, c);
      for (let c = 0, to = met * record + r * width; c < channels; c++)
        for (let k = 0; k < count; k++, to++) {
          let x = room[c * count + k];
          if (blocks) {
            x = float(float(colour[v + c] * room[k]) + float(colour[v + 3 + c] * room[count + k]));
            x = float(x + float(colour[v + 6 + c] * room[2 * count + k]));
          }
          data[to] += float(float(x * step[r]) * unweight[k]);
        }
    }
  }
  return { data, rows, record, width, count, channels, ways, predict, exponent, steps, add };
}

/* ---- streams of points ------------------------------------------------------- */

/* Tables by class and component; of each its symbols' slots. */
function fewTables(components, bytes) {
  const coder = fewCoder(bytes), below = chances(64 * 64), beside = chances(64 * 64), frequency = chances(32 * 64), used = chances(1);
  const table = new Uint8Array(FEW.CLASSES * components), slot = new Uint32Array(FEW.TABLES * FEW.SUM);
  for (let i = components; i < table.length; i++)
    table[i] = coder.symbolOf(below, 64 * table[i - components], beside, 64 * (i % components ? table[i - 1] : 0), 6);
  for (let t = 0; t < FEW.TABLES; t++) {
    let sum = 0;
    for (let s = 0; t && s < FEW.SYMBOLS; s++) {
      if (s === 0 && !coder.bit(used, 0)) break;
      const f = coder.number(frequency, 64 * s);
      if (f > FEW.SUM - sum) damagedFew('its tables');
      for (let k = 0; k < f; k++) slot[t * FEW.SUM + sum + k] = s | f << 5 | k << 17;
      sum += f;
    }
    if (sum !== FEW.SUM && sum) damagedFew('its tables');
    for (; sum < FEW.SUM; sum++) slot[t * FEW.SUM + sum] = FEW.MOST | FEW.SUM << 5 | sum << 17;
  }
  if (coder.isShort()) damagedFew('its tables');
  return { table, slot };
}

/* Of each class, row and channel the coefficients that are coded. */
function codedOf(table, count) {
  const out = [];
  for (let i = 0; i < table.length; i += count) {
    const list = [];
    for (let k = 0; k < count; k++) if (table[i + k]) list.push(k);
    out.push(Uint16Array.from(list));
  }
  return out;
}

/* Whole numbers by tables; four states take turns. */
function fewNumbers(bytes, raw, slot) {
  if (bytes.length < 16) damagedFew('its numbers');
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length), state = new Uint32Array(4);
  for (let i = 0; i < 4; i++) state[i] = view.getUint32(4 * i, true);
  let at = 16, rawAt = 0, turn = 0;
  function bitsOf(n) {
    let out = 0;
    if (rawAt + n > 8 * raw.length) damagedFew('its numbers');
    for (let i = 0; i < n; i++, rawAt++) out |= (raw[rawAt >> 3] >> (rawAt & 7) & 1) << i;
    return out;
  }
  function take(table) {
    let x = state[turn];
    const s = slot[table * FEW.SUM + (x & FEW.SUM - 1)], symbol = s & 31;
    x = Math.imul(s >>> 5 & 0xfff, x >>> FEW.BITS) + (s >>> 17) >>> 0;
    if (x < 65536) {
      if (at + 2 > bytes.length) damagedFew('its numbers');
      x = (x << 16 | bytes[at] | bytes[at + 1] << 8) >>> 0;
      at += 2;
    }
    state[turn] = x;
    turn = turn + 1 & 3;
    if (symbol <= 2 * FEW.MOST) return symbol - FEW.MOST;
    const k = symbol - 2 * FEW.MOST - 1, bits = bitsOf(k < FEW.LONG ? k + 1 : FEW.LONG_BITS);
    const size = 2 ** k + (bits >>> 1) + FEW.MOST;
    return bits & 1 ? -size : size;
  }
  const isDone = () => at === bytes.length && rawAt + 7 >> 3 === raw.length && state.every(x => x === 65536);
  return { take, isDone };
}

/* What stands beside a point's numbers, of one after another. */
function fewPoints(bytes, channels, kinds, hasValidity) {
  const coder = fewCoder(bytes), way = chances(3), invalid = chances(2), validity = chances(8 * 256), exponents = chances(3 * 64);
  const above = chances(kinds * 1024), left = chances(kinds * 1024), before = { exponent: 0, invalid: 0, validity: 0, way: 0,
    classes: new Uint8Array(kinds) };
  const wayOf = ways => { before.way = ways === 3 ? 1 + coder.bit(way, before.way) : ways; return before.way; };
  const next = (ways, expected) => {
    const p = before, c = p.classes;
    p.invalid = coder.bit(invalid, p.invalid);
    if (hasValidity) p.validity = coder.symbol(validity, 256 * (p.validity >> 5), 8);
    p.exponent = (ways ? expected : p.exponent) + coder.signed(exponents, 64 * (ways > 1 ? 1 : ways ? 2 : 0));
    for (let k = 0; k < kinds; k++) {
      const other = k >= channels ? c[k - channels] : k ? c[k - 1] : 0;
      c[k] = coder.symbolOf(above, 1024 * k + 32 * c[k], left, 1024 * k + 32 * other, 5);
    }
    if (!(Math.abs(p.exponent) <= 256) || coder.isShort()) damagedFew('its points');
    return p;
  };
  return { wayOf, next };
}

/* ---- all --------------------------------------------------------------------- */

function fewHead(bytes) {
  if (bytes.length !== 64) damagedFew('its head');
  const v = new DataView(bytes.buffer, bytes.byteOffset, bytes.length), u = i => v.getUint32(4 * i, true), f = i => v.getFloat32(4 * i, true);
  const head = { version: u(0), turn: u(1), step: f(2), slopes: f(3), least: f(4), most: f(5), degree: f(6), loose: u(7), flags: u(14) };
  const within = (x, low, high) => x >= low && x <= high;
  if (head.version !== 1 || head.turn > 2 || !within(head.step, 1e-10, 10) || !within(head.slopes, 1e-4, 1e3) ||
    !within(head.least, 1e-38, 1e38) || !within(head.most, head.least, 1e38) || !within(head.degree, 1e-4, 1)) damagedFew('its head');
  return head;
}

/* Cells as a shader walks them: what the layout says is put where the section has 0. Parts stand behind all cells. */
function fewCells(words, layout, place) {
  const c = layout.cells, s = layout.sides, parts = words.length / 12 - s.leaf.length;
  function put(w, i, corners) {
    const whole = corners.includes(FEW.NONE) ? 0 : 256;
    words[w + 1] = c.level[i] | whole | c.flags[i] << 16;
    words[w + 2] = c.origin[3 * i] | c.origin[3 * i + 1] << 16;
    words[w + 3] |= c.origin[3 * i + 2];
    for (let k = 0; k < 8; k++) words[w + 4 + k] = corners[k] === FEW.NONE ? FEW.NONE : place[corners[k]];
  }
  for (let i = 0; i < c.cells; i++) {
    put(12 * i, i, layout.cornersOf(i));
    if (!(c.flags[i] & FEW.LEAF)) words[12 * i] = c.child[i];
  }
  s.cell.forEach((i, n) => { words[12 * i] = n * FEW.SIDE; });
  s.leaf.forEach((i, n) => put(12 * (parts + n), i, layout.cornersOf(c.cells + n)));
}

/* Leaves with sides as a shader reads them; `first`: the cell that the first part is. */
function fewSides(layout, first) {
  const s = layout.sides, words = new Uint32Array(FEW.SIDE * s.cell.length);
  s.pieces.forEach((pieces, n) => {
    const w = FEW.SIDE * n;
    words.set([first + s.first[n], layout.endOf(n) - s.first[n]], w);
    pieces.forEach((part, i) => { words[w + 2 + (i >> 3)] |= part << 4 * (i & 7); });
  });
  return words;
}

/* Where points stand in the end: ghosts last. */
function fewPlaces(points) {
  const place = new Uint32Array(points.met);
  let next = 0;
  for (let ghosts = 0; ghosts < 2; ghosts++)
    for (let i = 0; i < points.met; i++) if (points.ghost[i] === ghosts) place[i] = next++;
  return place;
}

/* A grid from the sections of a page: { layout, place [points], data [points][rows][width], flags [points] by places }. `rest` is
   awaited now and then. */
async function decodeFew(facts, s, rest) {
  const head = fewHead(s.head), layout = layOutFew(facts, head, s.tree), n = layout.points.met;
  await rest(0);
  const f = fewFrame(facts, head, layout, s.bases, s.frame), lists = f.rows * f.channels, place = fewPlaces(layout.points);
  const components = lists * f.count;
  const { table, slot } = fewTables(components, s.tables), coded = codedOf(table, f.count), numbers = fewNumbers(s.numbers, s.bits, slot);
  const { wayOf, next } = fewPoints(s.points, f.channels, f.rows > 1 ? 2 * f.channels : f.channels, head.flags & 2);
  const number = new Float32Array(f.record), flags = new Uint8Array(n);
  const used = new Uint8Array(4), rise = float(FEW.RISE);
  for (let met = 0; met < n; met++) {
    const ways = f.ways(met);
    f.predict(met, wayOf(ways));
    const p = next(ways, f.exponent(met));
    number.fill(0);
    used.fill(0);
    for (let i = 0; i < lists; i++) {
      const kind = p.classes[i < f.channels ? i : f.channels + i % f.channels];
      if (!kind) continue;
      used[i / f.channels | 0] = 1;
      const list = coded[kind * lists + i], first = i * f.count, tables = kind * components + first;
      for (let k = 0; k < list.length; k++) {
        const q = numbers.take(table[tables + list[k]]);
        number[first + list[k]] = q > 0 ? q + rise : q < 0 ? q - rise : 0;
      }
    }
    f.add(met, f.steps(met, p.exponent), number, used);
    flags[place[met]] = p.invalid | (layout.points.ghost[met] ? FEW.GHOST : 0);
    if ((met & 255) === 0) await rest(met / n);
  }
  if (!numbers.isDone()) damagedFew('the end of its numbers');
  let zero = 0;
  for (let i = 0; i < f.data.length; i++) zero += 0 * f.data[i];
  if (zero !== 0) damagedFew('its coefficients');
  const data = layout.points.ghost.includes(1) ? new Float32Array(f.data.length) : f.data;
  for (let i = 0; data !== f.data && i < n; i++) data.set(f.data.subarray(i * f.record, (i + 1) * f.record), place[i] * f.record);
  return { layout, place, data, flags };
}
