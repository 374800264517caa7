-- The site of `make docs`: its pages and pictures are found from one another, and the check finds one that is not.

local scratch = require "spec.support.scratch"
local tool = require "spec.support.tool"

local site = tool.command .. "run lua/ylm/doc/site.lua "

describe("the site", function()
  local folder
  setup(function() folder = scratch.new() end)
  teardown(function() folder:remove() end)

  local function check() return scratch.capture(site .. "--check " .. scratch.quote(folder.path .. "/site")) end

  it("has every page and picture of docs, and no link that leads nowhere", function()
    local function lacks(command) return not scratch.shell("{ " .. command .. "; } >/dev/null 2>&1") end
    if lacks "command -v ldoc" then pending "ldoc is not installed" end
    if lacks [[lua5.1 -e 'require "discount"' || lua5.2 -e 'require "discount"']] then pending "discount is not installed" end
    local out, status = scratch.capture(site .. ". " .. scratch.quote(folder.path .. "/site"))
    assert.equal(0, status, out)
    for _, path in ipairs(scratch.lines "ls docs/*.md docs/images/*") do
      local name = path:match "[^/]+$"
      local at = name:find "%.md$" and "topics/" .. name .. ".html" or "topics/images/" .. name
      assert(folder:read("site/" .. at), at)
    end
    out, status = check()
    assert.equal(0, status, out)
    assert(tonumber(out:match "^(%d+) links and pictures, 0 broken") > 1000, out)
  end)

  it("is found wanting where a page, a heading or a picture is not there", function()
    if not folder:read "site/index.html" then pending "the site was not made" end
    folder:write("site/planted.html", '<a href="nowhere.html">a</a> <a href="topics/math.md.html#nothing">b</a>'
      .. '<img src="topics/images/none.png"/> <a href="topics/math.md.html#products">c</a>')
    local out, status = check()
    assert.equal(1, status)
    for _, target in ipairs { "nowhere.html", "topics/math.md.html#nothing", "topics/images/none.png" } do
      assert(out:find("planted.html: " .. target, 1, true), out)
    end
    assert(out:find "links and pictures, 3 broken", out)
  end)
end)
