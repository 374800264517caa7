--- three.js' LightProbeGridWebGL, baked in Chromium: a rival of ylm's exports.
--
-- YLM_NODE_MODULES=DIR names a folder with npm's three (0.187 or later). Lamps are point lights with shadow maps, a sky is the
-- background, panels shine by themselves.

local browser_page = require "spec.support.three_page"
local plain = require "spec.bench.rivals.plain"
local reader = require "spec.support.engine_reader"
local scratch = require "spec.support.scratch"

local three = { name = "three.js" }

local MOST_LAMPS = 8 -- shadow maps, of 16 textures that a fragment shader has at least

--- Why it cannot run here, or nil.
function three.lacks()
  if not browser_page.modules then return "not here: npm install three, and YLM_NODE_MODULES=DIR/node_modules" end
  if not browser_page.browser() then return "not here: apt-get install chromium" end
end

function three.version()
  return scratch.text(browser_page.modules .. "/three/package.json"):match '"version": "([^"]*)"'
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
	const material = new THREE.MeshBasicMaterial( { color: new THREE.Color( ...p.radiance ), side: THREE.DoubleSide,
		transparent: true, blending: THREE.AdditiveBlending, depthWrite: false } ); // rays pass lamps of ylm
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

--- Bakes a lattice { lo, hi, cells }: what an engine reads, as of engine_reader, and processor seconds; or nil, why not.
function three.bake(scene, lattice, bounces, cube)
  local all = plain.of(scene)
  if #all.lamps > MOST_LAMPS then return nil, ("not run: %d lamps, and shaders have 16 textures"):format(#all.lamps) end
  local folder, json = scratch.new(), plain.json
  local parts = { MESHES = json(all.meshes), LAMPS = json(all.lamps), PANELS = json(all.panels), SKY = all.sky and json(all.sky)
    or "null", LO = json(lattice.lo), HI = json(lattice.hi), CELLS = json(lattice.cells), CUBE = cube, BOUNCES = bounces }
  local page = folder:write("page.html", (PAGE:gsub("@(%u+)@", parts)))
  local from = scratch.quote(browser_page.modules)
  scratch.shell(("cp -r %s/three/build %s/three/examples %s/"):format(from, from, scratch.quote(folder.path)))
  local text, _, seconds = browser_page.result(folder, page, 900, plain.counted)
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
