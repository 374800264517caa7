-- Refusals of ylm.gltf and of scene:save.

-- The sentence of a build without jansson.
local missing = select(3, require "ylm".gltf { file = "/nonexistent.glb" }) == "EMISSING" and "glTF needs jansson" or nil

local function case(call, says) return { call = call, says = says } end

return {
  gltf = {
    case(function(ylm) ylm.gltf {} end, "gltf: field 'file' is missing"),
    case(function(ylm) ylm.gltf { file = "" } end, "gltf: file must be a file name"),
    case(function(ylm) ylm.gltf { file = "a\0b" } end, "gltf: file must be a file name"),
    case(function(ylm) ylm.gltf { file = "x.glb", lamp_radius = 0 } end, "lamp_radius must be a number > 0"),
    case(function(ylm) ylm.gltf { file = "x.glb", spots = "cone" } end, "spots must be one of 'spot', 'sphere'"),
    case(function(ylm) ylm.gltf { file = "x.glb", scene = 0 } end, "scene must be an integer >= 1, got 0"),
    case(function(ylm) return ylm.gltf { file = "/nonexistent.glb" } end, missing or "No such file"),
    case(function(ylm) return ylm.gltf { file = "README.md" } end, "README.md: line 1, column 1: not JSON"),
  },
  ["scene:save"] = {
    case(function(ylm) ylm.scene "x" {}:save() end, "a file name that ends in .glb or .gltf expected, got nil"),
    case(function(ylm) ylm.scene "x" {}:save "x.obj" end, "a file name that ends in .glb or .gltf expected"),
    case(function(ylm) ylm.scene "x" {}:save "a\0b.glb" end, "a file name that ends in .glb or .gltf expected"),
    case(function(ylm) ylm.scene "x" {}.save(5, "x.glb") end, "a scene expected before the colon, got 5"),
    case(function(ylm) ylm.scene "x" {}:save("x.glb", { separate = true }) end, "separate is for .gltf"),
    case(function(ylm) ylm.scene "x" {}:save("x.glb", { seperate = true }) end, "did you mean 'separate'"),
    case(function(ylm) return ylm.scene "x" {}:save "/nonexistent/x.glb" end, "No such file"),
    case(function(ylm)
      local at = {}
      for i = 1, 20001 do at[i] = { i, 0, 0 } end
      return ylm.scene "x" { lights = ylm.sphere_lights { at = at } }:save "/nonexistent/x.glb"
    end, "20001 lamps, at most 20000 are written"),
  },
}
