-- Refusals of ylm.scene and the form.

local nan = 0 / 0

local contains_itself = {}
contains_itself[1] = contains_itself

local fields = {
  { call = function(ylm) ylm.scene "x" { lihgts = {} } end, says = "scene: no field 'lihgts' %(did you mean 'lights'" },
  { call = function(ylm) ylm.scene "x" { 1 } end, says = "unexpected entry 1: fields are given by name" },
  { call = function(ylm) ylm.scene "x" { camera = {} } end, says = "camera must be a camera, got a table" },
  { call = function(ylm) ylm.scene "x" { geometry = 3 } end, says = "geometry must be a list, got 3" },
  { call = function(ylm) ylm.scene "x" { geometry = { {}, { "cube" } } } end,
    says = "geometry%[2%]%[1%] must be geometry %(.*%), got 'cube'" },
  { call = function(ylm) ylm.scene "x" { geometry = { [3] = {} } } end, says = "geometry%[1%] is nil" },
  { call = function(ylm) ylm.scene "x" { geometry = { wall = {} } } end, says = "unexpected entry 'wall' in a list" },
  { call = function(ylm) ylm.scene "x" { geometry = contains_itself } end, says = "nested more than 32 deep" },
  { call = function(ylm) ylm.scene "x" { lights = { ylm.scene "y" {} } } end,
    says = "lights%[1%] must be a light %(.*%), got a scene" },
  { call = function(ylm) ylm.scene "x" { lights = ylm.zeros { 3 } } end, says = "lights must be a light" },
  { call = function(ylm) ylm.scene "x" { probes = 5 } end, says = "probes must be a adaptive_grid or a uniform_grid" },
  { call = function(ylm) ylm.scene "x" { background = -1 } end, says = "background must be .* >= 0, got %-1" },
  { call = function(ylm) ylm.scene "x" { background = { 1, nan, 1 } } end, says = "background must be" },
  { call = function(ylm) ylm.scene "x" { like = 3 } end, says = "like must be the name of a scene file or of a glTF file, a scene or a gltf, got 3" },
  { call = function(ylm) return ylm.scene "x" { like = "no such.lua" } end, says = "no such.lua" },
  { call = function(ylm) ylm.scene "x" { moved = {} } end, says = "moved changes the lights of another scene, which like names" },
  { call = function(ylm) ylm.scene "x" { like = ylm.scene "y" {}, removed = { 1 } } end,
    says = "removed: a number of one of the 0 lights of \"y\" expected, got 1" },
  { call = function(ylm) ylm.scene "x" (nil) end, says = "a table of named fields expected, got nil" },
  { call = function(ylm) ylm.scene "x" (ylm.scene "y" {}) end, says = "a table of named fields expected" },
}

local cases = {
  scene = {
    { call = function(ylm) ylm.scene {} end, says = "the scene's name comes first" },
    { call = function(ylm) ylm.scene(("x"):rep(201)) end, says = "at most 200 characters" },
    { call = function(ylm) ylm.scene "a\27[2Jb" end, says = "none of them for control" },
    { call = function(ylm) ylm.scene() end, says = "the scene's name comes first" },
  },
}
for _, case in ipairs(fields) do table.insert(cases.scene, case) end
return cases
