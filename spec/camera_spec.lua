local ylm = require "ylm"

local function message(f)
  local ok, text = pcall(f)
  assert.is_false(ok)
  return text
end

describe("camera and matte", function()
  it("default to looking at the origin with y up, and to a grey of a half", function()
    local c = ylm.camera { from = { 0, 1, 5 } }
    assert.same({ 0, 0, 0 }, c.at)
    assert.same({ 0, 1, 0 }, c.up)
    assert.equal(45, c.fov)
    assert.same({ 0.5, 0.5, 0.5 }, ylm.matte {}.albedo)
    assert.same({ 0.1, 0.2, 0.3 }, ylm.matte { albedo = { 0.1, 0.2, 0.3 } }.albedo)
  end)

  it("refuse what makes no picture, at the caller's line", function()
    assert.matches("camera_spec.lua:%d+: camera: from and at must be different",
      message(function() ylm.camera { from = { 1, 2, 3 }, at = { 1, 2, 3 } } end))
    assert.matches("up must not point along",
      message(function() ylm.camera { from = { 0, 5, 0 }, at = { 0, 0, 0 } } end))
    assert.matches("fov must be a number > 0", message(function() ylm.camera { from = { 0, 1, 5 }, fov = 0 } end))
    assert.matches("albedo must be", message(function() ylm.matte { albedo = 1.5 } end))
  end)
end)
