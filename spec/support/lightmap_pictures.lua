-- docs/images/lightmap.png: a room by three.js with its lightmap, and in ylm's page. YLM_NODE_MODULES=DIR names a folder with
-- npm's three: build/ylm run spec/support/lightmap_pictures.lua

local browser = require "spec.support.browser"
local core = require "ylm.c.core"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

local modules = assert(os.getenv "YLM_NODE_MODULES", "YLM_NODE_MODULES is wanted")
local W, H = 480, 360
local folder = scratch.new()
local room = assert(ylm.load "examples/scenes/room.lua")
local geometry = { ylm.sphere { at = { -0.45, 0.4, -0.3 }, radius = 0.4, material = ylm.matte { albedo = { 0.6, 0.55, 0.3 } } },
  ylm.torus { at = { 0.15, 0.09, 0.45 }, radius = 0.2, tube = 0.09, material = ylm.matte { albedo = { 0.3, 0.4, 0.6 } } } }
for i = 1, 6 do geometry[#geometry + 1] = room.geometry[i] end -- without the balls of metal
local scene = ylm.scene "Room" { geometry = geometry, lights = room.lights, camera = room.camera }
local light = assert(scene:lightmap { texels = 65536, light_samples = 32, rays = 128 })
assert(light:save(folder.path .. "/room.html"))
assert(light:save(folder.path .. "/room.glb", { embed = true }))

local PAGE = [[<!doctype html><style>body { margin: 0; }</style><body>
<script type="importmap">{"imports":{"three":"./three/build/three.module.js","three/addons/":"./three/examples/jsm/"}}</script>
<script type="module">
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { lightBy, mapOf } from './lightmap.js';
const gltf = await new GLTFLoader().parseAsync( Uint8Array.from( atob( '@' ), c => c.charCodeAt( 0 ) ).buffer, '' );
lightBy( gltf.scene, await mapOf( gltf ) );
const renderer = new THREE.WebGLRenderer( { antialias: true } );
renderer.setSize( innerWidth, innerHeight );
renderer.toneMapping = THREE.NeutralToneMapping;
document.body.append( renderer.domElement );
const scene = new THREE.Scene(), camera = gltf.cameras[ 0 ];
scene.add( gltf.scene );
camera.aspect = innerWidth / innerHeight;
camera.updateProjectionMatrix();
renderer.render( scene, camera );
document.documentElement.dataset.state = 'ready';
</script></body>]]

assert(scratch.shell(("cp package/three/lightmap.js %s/ && ln -s $(realpath %s)/three %s/three"):format(folder.path, modules,
  folder.path)))
folder:write("three.html", (PAGE:gsub("'@'", function() return "'" .. core.page_base64(folder:read "room.glb") .. "'" end)))

local window = browser.open { size = { W, H }, limit = 600, switches = "--headless=new --use-angle=swiftshader "
  .. "--enable-unsafe-swiftshader --hide-scrollbars --force-device-scale-factor=1 --allow-file-access-from-files" }
local sheet = ylm.image { size = { 2 * W, 2 * H } }
local function shot(x, y, words)
  window:wait "ready"
  sheet:paste(assert(ylm.load(window:screenshot(folder.path .. "/shot.png"))), x, y)
  sheet:text(x + 10, y + 10, words, { colour = { 1, 1, 1 }, scale = 2 })
end
window:visit(folder.path .. "/three.html")
shot(1, 1, "three.js")
window:visit(folder.path .. "/room.html", "mode=charts&bare")
shot(W + 1, 1, "charts and texels")
window:go "mode=density&bare"
window:eval "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
window:eval "document.documentElement.dataset.state = 'ready'"
shot(1, H + 1, "texels a scene unit")
window:go "mode=error&bare"
window:eval "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
window:eval "document.documentElement.dataset.state = 'ready'"
shot(W + 1, H + 1, "error of charts")
for _, s in ipairs(window.said) do print(s) end
window:close()
assert(sheet:save "docs/images/lightmap.png")
folder:remove()
