-- Names of the module: version, misspelt ones, those of other versions.

local ylm = require "ylm"

describe("names of the module", function()
  it("include its version", function()
    assert.equal("string", type(ylm.version))
    assert.matches("^%d+%.%d+%.%d+$", ylm.version)
    assert.equal(ylm.info().version, ylm.version)
  end)

  it("raise at the caller's line where they are misspelt, with a guess", function()
    for what, call in pairs {
      ["no ylm.sphere_ligth (did you mean 'sphere_light'?)"] = function() return ylm.sphere_ligth {} end,
      ["no ylm.adaptiv_grid (did you mean 'adaptive_grid'?)"] = function() return ylm.adaptiv_grid {} end,
      ["no ylm.verison (did you mean 'version'?)"] = function() return ylm.verison .. "" end,
      ["no ylm.sh.evla (did you mean 'eval'?)"] = function() return ylm.sh.evla(4, { 0, 0, 1 }) end,
      ["no ylm.sh.cuont (did you mean 'count'?)"] = function() return ylm.sh.cuont(4) end,
      ["no ylm.vulkan.opne (did you mean 'open'?)"] = function() return ylm.vulkan.opne {} end,
      ["no ylm.array.frombyte (did you mean 'frombytes'?)"] = function() return ylm.array.frombyte "" end,
    } do
      local ok, message = pcall(call)
      assert.is_false(ok)
      assert.matches("names_spec%.lua:%d+: ", message)
      assert.equal(what, (message:gsub("^.-: ", "")))
    end
  end)

  it("are nil where no name is near: programs ask for what another version has", function()
    for _, t in ipairs { ylm, ylm.sh, ylm.vulkan, ylm.array } do
      for _, name in ipairs { "hologram", "__gc", "_VERSION", 1, false, ("x"):rep(300) } do assert.is_nil(t[name]) end
      assert.is_nil(rawget(t, "sphere_ligth"))
      for name in pairs(t) do assert(t[name] ~= nil, name) end
    end
    for _, name in ipairs(ylm.names()) do assert(ylm[name] ~= nil, name) end
  end)
end)
