--- three.js' LightProbeGridWebGL, baked in Chromium: a rival of ylm's exports.
--
-- YLM_NODE_MODULES=DIR names a folder with npm's three (0.187 or later). Lamps are point lights with shadow maps, a sky is the
-- background, panels shine by themselves.

local browser_page = require "spec.support.three_page"
local form = require "ylm.form"
local reader = require "spec.support.engine_reader"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

local three = {}

local MOST_LAMPS = 8 -- shadow maps, of 16 textures that a fragment shader has at least
local SKY = { 64, 32 }
local GLOSSY = { 0.9, 0.9, 0.9 } -- of materials without albedo, which are matte there

--- Why it cannot run here, or nil.
function three.lacks()
  if not browser_page.modules then return "not here: npm install three, and YLM_NODE_MODULES=DIR/node_modules" end
  if not browser_page.browser() then return "not here: apt-get install chromium" end
end

local function numbers(list)
  local words = {}
  for i, x in ipairs(list) do words[i] = ("%.7g"):format(x) end
  return "[" .. table.concat(words, ",") .. "]"
end

--- The meshes of a scene: positions of triangles, colours, and the side that reflects.
local function meshes_of(scene)
  local list = {}
  for _, g in ipairs(scene.geometry) do
    local vertices, triangles, positions = g.mesh:vertices():totable(), g.mesh:triangles():totable(), {}
    for _, t in ipairs(triangles) do
      for k = 1, 3 do for a = 1, 3 do positions[#positions + 1] = vertices[t[k]][a] end end
    end
    local albedo = g.material and g.material.albedo
    if type(albedo) == "number" then albedo = { albedo, albedo, albedo } end
    if type(albedo) ~= "table" then albedo = GLOSSY end
    list[#list + 1] = ('{"positions":%s,"colour":%s,"side":"%s"}'):format(numbers(positions), numbers(albedo), g.sides or "both")
  end
  return "[" .. table.concat(list, ",") .. "]"
end

--- The sky's radiance at SKY directions, from the top row on; nil where there is none.
local function sky_of(scene)
  for _, light in ipairs(scene.lights) do
    if form.kind(light) == "environment_light" then
      local directions = {}
      for y = 1, SKY[2] do
        for x = 1, SKY[1] do
          local theta, phi = (y - 0.5) / SKY[2] * math.pi, ((x - 0.5) / SKY[1] - 0.5) * 2 * math.pi
          directions[#directions + 1] = { math.sin(theta) * math.cos(phi), math.cos(theta), math.sin(theta) * math.sin(phi) }
        end
      end
      local c = ylm.light_field(20, light, { { 0, 0, 0 } }):reshape { 3, 441 }
      local L, out = ylm.sh.reconstruct(c, directions):totable(), {}
      for i = 1, #directions do for channel = 1, 3 do out[#out + 1] = math.max(0, L[channel][i]) end end
      return numbers(out)
    end
  end
end

--- Lamps and panels; or nil, why not.
local function lamps_of(scene)
  local lamps, panels = {}, {}
  for _, light in ipairs(scene.lights) do
    local kind = form.kind(light)
    if kind == "sphere_light" then
      local power = {}
      for c = 1, 3 do power[c] = math.pi * light.radius ^ 2 * light.radiance[c] end
      lamps[#lamps + 1] = ('{"at":%s,"power":%s}'):format(numbers(light.at), numbers(power))
    elseif kind == "polygon_light" then
      local corners = {}
      for _, v in ipairs(light.vertices) do for a = 1, 3 do corners[#corners + 1] = v[a] end end
      panels[#panels + 1] = ('{"corners":%s,"radiance":%s}'):format(numbers(corners), numbers(light.radiance))
    elseif kind ~= "environment_light" then return nil, "it has no " .. kind
    end
  end
  if #lamps > MOST_LAMPS then return nil, ("not run: %d lamps, and shaders have 16 textures"):format(#lamps) end
  return "[" .. table.concat(lamps, ",") .. "]", "[" .. table.concat(panels, ",") .. "]"
end

local PAGE = [[<!doctype html><body><script type="importmap">{"imports":{"three":"./build/three.module.js"}}</script>
<script type="module">
import * as THREE from 'three';
import { LightProbeGridWebGL } from './examples/jsm/lighting/LightProbeGridWebGL.js';
const meshes = @MESHES@, lamps = @LAMPS@, panels = @PANELS@, sky = @SKY@, lo = @LO@, hi = @HI@, cells = @CELLS@;
const renderer = new THREE.WebGLRenderer();
renderer.shadowMap.enabled = true;
const scene = new THREE.Scene();
const sides = { front: THREE.FrontSide, back: THREE.BackSide, both: THREE.DoubleSide };
for ( const m of meshes ) {
	const geometry = new THREE.BufferGeometry();
	geometry.setAttribute( 'position', new THREE.Float32BufferAttribute( m.positions, 3 ) );
	geometry.computeVertexNormals();
	const material = new THREE.MeshLambertMaterial( { color: new THREE.Color( ...m.colour ), side: sides[ m.side ] } );
	material.shadowSide = THREE.DoubleSide;
	const mesh = new THREE.Mesh( geometry, material );
	mesh.castShadow = mesh.receiveShadow = true;
	scene.add( mesh );
}
for ( const l of lamps ) {
	const light = new THREE.PointLight( new THREE.Color( ...l.power ), 1, 0, 2 );
	light.position.set( ...l.at );
	light.castShadow = true;
	light.shadow.mapSize.set( 1024, 1024 );
	light.shadow.camera.near = 0.02;
	light.shadow.camera.far = 20;
	light.shadow.bias = - 0.0005; // of far: 1 cm
	scene.add( light );
}
for ( const p of panels ) {
	const geometry = new THREE.BufferGeometry();
	geometry.setAttribute( 'position', new THREE.Float32BufferAttribute( p.corners, 3 ) );
	const index = [];
	for ( let i = 2; i < p.corners.length / 3; i ++ ) index.push( 0, i - 1, i );
	geometry.setIndex( index );
	const material = new THREE.MeshBasicMaterial( { color: new THREE.Color( ...p.radiance ), side: THREE.DoubleSide } );
	scene.add( new THREE.Mesh( geometry, material ) );
}
if ( sky ) {
	const data = new Float32Array( 4 * 64 * 32 );
	for ( let y = 0; y < 32; y ++ ) for ( let x = 0; x < 64; x ++ ) for ( let c = 0; c < 4; c ++ )
		data[ 4 * ( y * 64 + x ) + c ] = c < 3 ? sky[ 3 * ( ( 31 - y ) * 64 + x ) + c ] : 1;
	const texture = new THREE.DataTexture( data, 64, 32, THREE.RGBAFormat, THREE.FloatType );
	texture.mapping = THREE.EquirectangularReflectionMapping;
	texture.needsUpdate = true;
	scene.background = texture;
}
const size = [ 0, 1, 2 ].map( a => hi[ a ] - lo[ a ] );
const grid = new LightProbeGridWebGL( ...size, ...cells );
grid.position.set( ...lo.map( ( x, a ) => x + size[ a ] / 2 ) );
scene.add( grid );
grid.bake( renderer, scene, { cubemapSize: @CUBE@, near: 0.02, far: 100, bounces: @BOUNCES@ } );
const gl = renderer.getContext(), [ nx, ny, nz ] = cells, target = grid._renderTarget;
const all = new Float32Array( 4 * nx * ny * 7 * nz );
for ( let t = 0; t < 7; t ++ ) for ( let z = 0; z < nz; z ++ ) {
	const slice = new Float32Array( 4 * nx * ny );
	renderer.setRenderTarget( target, t * ( nz + 2 ) + 1 + z );
	gl.readPixels( 0, 0, nx, ny, gl.RGBA, gl.FLOAT, slice );
	all.set( slice, 4 * nx * ny * ( t * nz + z ) );
}
const pre = document.createElement( 'pre' );
pre.textContent = 'BEGIN ' + Array.from( all ).map( x => x.toPrecision( 5 ) ).join( ' ' ) + ' END';
document.body.append( pre );
</script></body>]]

--- Bakes a lattice { lo, hi, cells }: what an engine reads, as of engine_reader, and seconds; or nil, why not.
function three.bake(scene, lattice, bounces, cube)
  local lamps, panels = lamps_of(scene)
  if not lamps then return nil, panels end
  local folder = scratch.new()
  local parts = { MESHES = meshes_of(scene), LAMPS = lamps, PANELS = panels, SKY = sky_of(scene) or "null",
    LO = numbers(lattice.lo), HI = numbers(lattice.hi), CELLS = numbers(lattice.cells), CUBE = cube, BOUNCES = bounces }
  local page = folder:write("page.html", (PAGE:gsub("@(%u+)@", parts)))
  local from = scratch.quote(browser_page.modules)
  scratch.shell(("cp -r %s/three/build %s/three/examples %s/"):format(from, from, scratch.quote(folder.path)))
  local began = os.time()
  local text = browser_page.result(folder, page, 900)
  local seconds = os.time() - began
  folder:remove()
  if not text then return nil, "the browser gave nothing" end
  local list, cells = {}, lattice.cells
  for word in text:gmatch "%S+" do list[#list + 1] = tonumber(word) end
  local function probe(x, y, z)
    local v = {}
    for k = 0, 26 do
      v[k + 1] = list[4 * (((math.floor(k / 4) * cells[3] + z) * cells[2] + y) * cells[1] + x) + k % 4 + 1]
    end
    return v
  end
  return reader.three { { lo = lattice.lo, hi = lattice.hi, cells = cells, probe = probe } }, seconds
end

return three
