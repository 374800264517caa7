--- Scenes of commands that bake lightmaps: a scene's file, or one of triangles under an overcast sky.

local status = require "ylm.cli.status"

local lit_scene = {}

--- The scene of a file: one of ylm.load, or a file of triangles, which an overcast sky lights where none of them emits.
function lit_scene.of(path)
  if not (path:lower():find "%.obj$" or path:lower():find "%.ply$") then return status.load_scene(path) end
  local ylm = require "ylm"
  local geometry, message, code = ylm.mesh { file = path }
  status.need(geometry, message, code)
  return status.need(ylm.scene(path:match "[^/]*$") { geometry = geometry, lights = not geometry.emitters
    and ylm.environment_light { sky = { kind = "overcast", zenith = { 0, 1, 0 }, luminance = 1 } } or nil })
end

--- That scene, where surfaces are needed.
function lit_scene.with_surfaces(path)
  local scene = lit_scene.of(path)
  if #scene.geometry == 0 then status.stop(status.script, "%s: the scene has no surfaces", path) end
  return scene
end

return lit_scene
