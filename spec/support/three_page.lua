--- Probes in three.js, in a browser: the irradiance that it reads, by the pixels of a white sphere.
--
-- YLM_NODE_MODULES=DIR names a folder with npm's `three` (0.187 or later); Chromium is needed too.

local core = require "ylm.c.core"
local patience = require "spec.support.patience"
local scratch = require "spec.support.scratch"

local page = {}

local modules = os.getenv "YLM_NODE_MODULES"
page.modules = modules

page.radius = 0.02                                 -- of the sphere
page.normals = { { 0, 0, 1 }, { 1, 0, 0 }, { 0, 1, 0 } }

--- The browser's command, or nil.
function page.browser()
  for _, name in ipairs { "chromium", "chromium-browser", "google-chrome" } do
    if scratch.shell("command -v " .. name .. " >/dev/null 2>&1") then return name end
  end
end

function page.there() return modules ~= nil and page.browser() ~= nil end

--- Text between BEGIN and END in the `pre` that a page in a folder leaves, or nil; all of its document; and the second answer
-- of `run`, by default scratch.capture.
function page.result(folder, name, seconds, run)
  local dom, also = (run or scratch.capture)(("timeout %d %s --headless --no-sandbox --disable-gpu-sandbox "
    .. "--use-angle=swiftshader --enable-unsafe-swiftshader --allow-file-access-from-files "
    .. "--virtual-time-budget=20000 --user-data-dir=%s/profile --dump-dom file://%s 2>/dev/null"):format(
    patience(seconds), page.browser(), scratch.quote(folder.path), name))
  return dom:match "<pre>BEGIN (.-) END</pre>", dom, also
end

local PAGE = [[<!doctype html><body><script type="importmap">{"imports":{"three":"./three.module.js"}}</script>
<script type="module">
import * as THREE from 'three';
%s
const renderer = new THREE.WebGLRenderer();
const target = new THREE.WebGLRenderTarget( 9, 9, { type: THREE.FloatType } );
const scene = new THREE.Scene(), camera = new THREE.PerspectiveCamera( 1, 1, 0.1, 10 );
const ball = new THREE.Mesh( new THREE.SphereGeometry( %g, 256, 128 ), new THREE.MeshLambertMaterial( { color: 0xffffff } ) );
scene.add( ball );
add( scene );
const out = [];
for ( const p of [%s] ) for ( const n of [ [ 0, 0, 1 ], [ 1, 0, 0 ], [ 0, 1, 0.0001 ] ] ) {
  ball.position.set( ...p );
  camera.position.set( p[ 0 ] + n[ 0 ], p[ 1 ] + n[ 1 ], p[ 2 ] + n[ 2 ] );
  camera.lookAt( ...p );
  renderer.setRenderTarget( target );
  renderer.render( scene, camera );
  const pixel = new Float32Array( 4 );
  renderer.readRenderTargetPixels( target, 4, 4, 1, 1, pixel );
  out.push( Array.from( pixel.slice( 0, 3 ) ).join( ' ' ) );
}
const pre = document.createElement( 'pre' );
pre.textContent = 'BEGIN ' + out.join( ',' ) + ' END';
document.body.append( pre );
</script></body>]]

local GRIDS = [[import { LoadedProbes } from './index.js';
const file = %s, add = scene => scene.add( ...( file.grids ?? [ file ] ).map( grid => new LoadedProbes( grid ) ) );]]
local BRICKS = [[import { BrickProbes } from './bricks.js';
const add = scene => new BrickProbes( Uint8Array.from( atob( '%s' ), c => c.charCodeAt( 0 ) ).buffer ).light( scene );]]

--- Irradiance over pi, three numbers for each place and each of page.normals, at the sphere's surface; `text` is the file, of
--- LightProbeGrids or, with `is_bricks`, of ylm's own probes.
function page.irradiance(folder, text, places, is_bricks)
  for _, name in ipairs { "three.module.js", "three.core.js" } do
    assert(scratch.shell(("cp %s/three/build/%s %s/"):format(scratch.quote(modules), name, scratch.quote(folder.path))))
  end
  assert(scratch.shell(("cp package/three/*.js %s/"):format(scratch.quote(folder.path))))
  local list = {}
  for i, p in ipairs(places) do list[i] = ("[%.9g,%.9g,%.9g]"):format(p[1], p[2], p[3]) end
  local setup = is_bricks and BRICKS:format(core.page_base64(text)) or GRIDS:format(text)
  local name = folder:write("page.html", PAGE:format(setup, page.radius, table.concat(list, ",")))
  local rows, pixels, dom = {}, page.result(folder, name, 120)
  assert(pixels, dom)
  for words in pixels:gmatch "[^,]+" do
    local rgb = {}
    for x in words:gmatch "%S+" do rgb[#rgb + 1] = tonumber(x) end
    rows[#rows + 1] = rgb
  end
  return rows
end

return page
