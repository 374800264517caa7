-- Files and folders that may not be read or written: nil, the system's words, "EIO"; an existing file stays as it was.

local scratch = require "spec.support.scratch"
local quote = scratch.quote

local lua = os.getenv "YLM_LUA" or "lua5.4"

--- The words before a command that make permissions count for it: root gives up the rights that set it above them.
local function obeying()
  if scratch.capture "id -u" :find "^0" then
    local drop = "setpriv --bounding-set=-dac_override,-dac_read_search "
    return scratch.shell(drop .. "true 2>/dev/null") and drop or nil
  end
  return ""
end

describe("permissions", function()
  local folder, prefix
  setup(function()
    prefix = obeying()
    folder = scratch.new()
    folder:write("make.lua", [[
      local ylm, folder = require "ylm", arg[1] .. "/"
      local lamp = ylm.sphere_light { at = { 0, 3, 0 } }
      local box = { { -1, -1, -1 }, { 1, 1, 1 } }
      local things = {
        ["a.npy"] = ylm.zeros { 3 }, ["i.exr"] = ylm.image { size = { 4, 4 } }, ["i.png"] = ylm.image { size = { 4, 4 } },
        ["i.hdr"] = ylm.image { size = { 4, 4 } }, ["i.pfm"] = ylm.image { size = { 4, 4 } }, ["m.ply"] = ylm.sphere {}.mesh,
        ["g.ylm"] = ylm.bake(ylm.uniform_grid { bounds = box, cells = 1, lmax = 1 }, lamp),
      }
      for name, thing in pairs(things) do
        local ok, message, code = thing:save(folder .. name)
        print("save " .. name, ok, message, code)
        ok, message, code = ylm.load(folder .. name)
        print("load " .. name, ok and true, message, code)
      end
      local ok, message, code = ylm.load(folder .. "s.lua")
      print("load s.lua", ok and true, message, code)
      os.exit(0)]])
    folder:write("s.lua", "return scene 's' {}")
  end)
  teardown(function()
    scratch.shell("chmod -R u+rwX " .. quote(folder.path))
    folder:remove()
  end)

  --- The output of the script about a folder, as { ["save a.npy"] = { ok, message, code } }.
  local function try(name)
    local out, status = scratch.capture(("%s%s %s %s"):format(prefix, lua, quote(folder.path .. "/make.lua"),
      quote(folder.path .. "/" .. name)))
    assert(status == 0, out)
    local told, n = {}, 0
    for what, ok, message, code in out:gmatch "([%w ]+ ?[%w.]+)\t(%w+)\t([^\n\t]*)\t?([^\n\t]*)\n" do
      told[what], n = { ok, message, code }, n + 1
    end
    assert.equal(15, n, out)
    return told
  end

  --- All that is said of one verb is a refusal in the system's words.
  local function refused(told, verb)
    for what, result in pairs(told) do
      if what:find(verb, 1, true) then
        assert.equal("nil", result[1], what)
        assert.truthy(result[2]:find "Permission denied", what .. ": " .. result[2])
        assert.equal("EIO", result[3], what)
      end
    end
  end

  it("of a folder that may not be entered, of one that may not be written, of files that may not be read", function()
    if not prefix then return pending "root cannot be held to permissions here" end
    assert(scratch.shell(("cd %s && mkdir good && cp s.lua good"):format(quote(folder.path))))
    for what, result in pairs(try "good") do assert.equal("true", result[1], what) end
    local before = scratch.capture("cd " .. quote(folder.path .. "/good") .. " && cksum *")

    assert(scratch.shell(("cd %s && chmod 000 good"):format(quote(folder.path))))
    local told = try "good"
    refused(told, "save")
    refused(told, "load")

    assert(scratch.shell(("cd %s && chmod 500 good"):format(quote(folder.path))))
    told = try "good"
    refused(told, "save")
    for what, result in pairs(told) do if what:find "load" then assert.equal("true", result[1], what) end end
    assert.equal(before, (scratch.capture("cd " .. quote(folder.path .. "/good") .. " && cksum *")))

    assert(scratch.shell(("cd %s && chmod 700 good && chmod 000 good/*"):format(quote(folder.path))))
    local out = scratch.capture(("%s%s -e %s"):format(prefix, lua, quote(([[
      local ylm = require "ylm"
      for _, name in ipairs { "a.npy", "i.exr", "i.png", "i.hdr", "i.pfm", "m.ply", "g.ylm" } do
        print(ylm.load(%q .. name))
      end
      print(ylm.load(%q .. "s.lua"))]]):format(folder.path .. "/good/", folder.path .. "/good/"))))
    local _, times = out:gsub("nil\t[^\n]*: Permission denied\tEIO\n", "")
    assert.equal(8, times, out)
  end)
end)
