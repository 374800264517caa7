-- Refusals of materials of files and functions, and of material:save. spec/material_file_spec.lua has those of damaged files.

local refused = require "spec.support.refused"

return {
  merl = refused(
    function(ylm) ylm.merl() end, "merl: a table of named fields expected, got nil",
    function(ylm) ylm.merl {} end, "merl: field 'file' is missing",
    function(ylm) ylm.merl { file = "" } end, "merl: file must be a file name, got ''",
    function(ylm) ylm.merl { file = "a\0b" } end, "merl: file must be a file name",
    function(ylm) ylm.merl { file = "x", interpolation = "near" } end, "interpolation must be one of 'linear', 'nearest'",
    function(ylm) ylm.merl { file = "x", rotate = 1 } end, "merl: no field 'rotate'",
    function(ylm) return ylm.merl { file = "/nonexistent.binary" } end, "No such file",
    function(ylm) return ylm.merl { file = "/" } end, "not a regular file",
    function(ylm) return ylm.merl { file = "LICENSE" } end, "LICENSE: %d+ x %d+ x %d+ bins of theta_h, theta_d and phi_d"),
  rgl = refused(
    function(ylm) ylm.rgl {} end, "rgl: field 'file' is missing",
    function(ylm) ylm.rgl { file = 3 } end, "rgl: file must be a file name, got 3",
    function(ylm) ylm.rgl { file = "x", rotate = 0 / 0 } end, "rgl: rotate must be a number",
    function(ylm) ylm.rgl { file = "x", rotat = 1 } end, "no field 'rotat' %(did you mean 'rotate'%?%)",
    function(ylm) return ylm.rgl { file = "/nonexistent.bsdf" } end, "No such file",
    function(ylm) return ylm.rgl { file = "LICENSE" } end, "LICENSE: not a tensor file"),
  tabulated = refused(
    function(ylm) ylm.tabulated {} end, "tabulated: field 'f' is missing",
    function(ylm) ylm.tabulated { f = 3 } end, "tabulated: f must be a function, got 3",
    function(ylm) ylm.tabulated { f = function() return 0 / 0 end } end,
      "f must return finite numbers that are not negative, got %-?nan at theta_i = .*, theta_o = .*, dphi = ",
    function(ylm) ylm.tabulated { f = function() return 1, -1, 1 end } end, "not negative, got %-1 at theta_i",
    function(ylm) ylm.tabulated { f = function() return math.huge end } end, "got inf at theta_i",
    function(ylm) ylm.tabulated { f = function() return 1, 2 end } end, "got nil at theta_i",
    function(ylm) ylm.tabulated { f = function() return "x" end } end, "got 'x' at theta_i",
    function(ylm) ylm.tabulated { f = function() end } end, "got nil at theta_i",
    function(ylm) ylm.tabulated { f = function(theta_i) return theta_i end } end,
      "f must be the same with both directions exchanged, but is {.*} at theta_i = .* and {.*} at theta_i = "),
  ["material:save"] = refused(
    function(ylm) ylm.matte {}:save() end, "bad argument #1 to 'save' %(a file name that ends in .binary expected, got nil%)",
    function(ylm) ylm.matte {}:save "x.bsdf" end, "a file name that ends in .binary expected, got 'x.bsdf'",
    function(ylm) return ylm.matte {}:save "/nonexistent/x.binary" end, "No such file",
    function(ylm) ylm.ggx { alpha = { 0.1, 0.2 } }:save "x.binary" end, "save: MERL's files hold isotropic materials, and this ggx",
    function(ylm)
      ylm.matte { albedo = ylm.image { size = { 2, 2 } } }:save "x.binary"
    end, "save: a texture is no part of MERL's files",
    function(ylm) ylm.matte {}.save(3, "x.binary") end, "save: a material expected before the colon, got 3"),
}
