--- Lightmaps in three.js, in a browser: the radiance of pixels at places of surfaces.

local core = require "ylm.c.core"
local page = require "spec.support.three_page"
local scratch = require "spec.support.scratch"

local lightmap = {}

local PAGE = [[<!doctype html><body><script type="importmap">{"imports":{"three":"./three/build/three.module.js",
"three/addons/":"./three/examples/jsm/"}}</script>
<script type="module">
import * as THREE from 'three';
import { EXRLoader } from 'three/addons/loaders/EXRLoader.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { lightBy, mapOf } from './lightmap.js';
const bytes = text => Uint8Array.from( atob( text ), c => c.charCodeAt( 0 ) ).buffer;
const gltf = await new GLTFLoader().parseAsync( bytes( '@GLB@' ), '' );
lightBy( gltf.scene, await mapOf( gltf, bytes( '@MAP@' ), EXRLoader ) );
const renderer = new THREE.WebGLRenderer();
const target = new THREE.WebGLRenderTarget( 9, 9, { type: THREE.FloatType } );
const scene = new THREE.Scene(), camera = new THREE.PerspectiveCamera( 1, 1, 1e-3, 10 );
scene.add( gltf.scene );
const out = [], pixel = new Float32Array( 4 );
for ( const [ p, n ] of @PLACES@ ) {
  camera.position.set( ...p.map( ( x, a ) => x + 0.01 * n[ a ] ) );
  camera.up.set( ...( Math.abs( n[ 1 ] ) > 0.9 ? [ 1, 0, 0 ] : [ 0, 1, 0 ] ) );
  camera.lookAt( ...p );
  renderer.setRenderTarget( target );
  renderer.render( scene, camera );
  renderer.readRenderTargetPixels( target, 4, 4, 1, 1, pixel );
  out.push( Array.from( pixel.slice( 0, 3 ) ).join( ' ' ) );
}
const pre = document.createElement( 'pre' );
pre.textContent = 'BEGIN ' + out.join( ',' ) + ' END';
document.body.append( pre );
</script></body>]]

local function listed(p) return ("[%.9g,%.9g,%.9g]"):format(p[1], p[2], p[3]) end

--- Radiance, three numbers for each place { point, normal }, of files of a lightmap in a folder: a .glb, and its picture or nil.
function lightmap.radiance(folder, glb, map, places)
  assert(scratch.shell(("cp package/three/lightmap.js %s/ && ln -sfn $(realpath %s)/three %s/three"):format(
    scratch.quote(folder.path), scratch.quote(page.modules), scratch.quote(folder.path))))
  local list = {}
  for i, p in ipairs(places) do list[i] = "[" .. listed(p[1]) .. "," .. listed(p[2]) .. "]" end
  local words = { GLB = core.page_base64(folder:read(glb)), MAP = map and core.page_base64(folder:read(map)) or "",
    PLACES = "[" .. table.concat(list, ",") .. "]" }
  local name = folder:write("three.html", (PAGE:gsub("@(%u+)@", words)))
  local pixels, dom = page.result(folder, name, 120)
  assert(pixels, dom)
  local rows = {}
  for r, g, b in pixels:gmatch "([^%s,]+) ([^%s,]+) ([^%s,]+)" do rows[#rows + 1] = { tonumber(r), tonumber(g), tonumber(b) } end
  return rows
end

return lightmap
