-- Programs that stand in pages of documentation.

local lacking = require "spec.support.run.lacking"
local long = require "spec.support.long"
local scratch = require "spec.support.scratch"

local blocks = {}

local build = os.getenv "YLM_BUILD" or "build"
local lua = os.getenv "YLM_LUA" or "lua5.4"
if not build:find "^/" then build = scratch.capture "pwd":gsub("%s+$", "") .. "/" .. build end

--- The Lua programs of a page, in order.
function blocks.of(text)
  local list = {}
  for language, code in (text .. "\n"):gmatch("```(%w+)\n(.-)```") do
    if language == "lua" then list[#list + 1] = code end
  end
  return list
end

--- A program whose pictures of scenes are a quarter as wide and high, whose scenes have few links, whose lattices of eight cells
-- and more have half of them along each axis, whose lightmaps have half as many texels along each side,
-- whose files have a quarter of the bytes, and whose tolerances of rooms' light are four times as wide; few paths judge plans,
-- and elements bounced light: its calls are those of the page.
local function small(code)
  code = code:gsub("(:%l+ { size = {) (%d%d%d+), (%d%d%d+) }", function(head, w, h)
    return ("%s %d, %d }"):format(head, math.floor(w / 4), math.floor(h / 4))
  end)
  if not code:find("links", 1, true) then
    code = code:gsub('(ylm%.scene "[^"]*" {)', "%1 links = ylm.links { spacing = 0.5, rays = 16 },")
  end
  code = code:gsub("(links { spacing = )(%d[%d.]*), rays = %d+", function(head, spacing)
    return ("%s%g, rays = 16"):format(head, 2 * spacing)
  end)
  code = code:gsub("(uniform_grid {[^}]-cells = {) (%d+), (%d+), (%d+) }", function(head, ...)
    local cells = { ... }
    for a = 1, 3 do cells[a] = ("%d"):format(tonumber(cells[a]) >= 8 and cells[a] / 2 or cells[a]) end
    return head .. " " .. table.concat(cells, ", ") .. " }"
  end)
  code = code:gsub(':bake { quantity = "indirect"', '%0, judge = "field"')
  code = code:gsub("texels = (%d%d+) %* (%d%d+)", function(w, h) return ("texels = %d * %d"):format(w / 2, h / 2) end)
  code = code:gsub("judge( +)= %d+", "judge%1= 128")
  code = code:gsub("(bytes = )(%d%d%d%d+)", function(head, n) return ("%s%d"):format(head, math.floor(n / 4)) end)
  local of = code:find('quantity = "indirect"', 1, true) and "" or ":surface_grid { "
  code = code:gsub("(" .. of .. "tolerance = )(0%.%d+)", function(head, x) return head .. math.min(4 * x, 0.5) end)
  return (code:gsub(":surface_grid { tolerance", ':surface_grid { judge = "field", tolerance'))
end

--- Runs the n-th program of a page in a scratch folder, by the tool: a scene file is baked. Returns what it printed.
-- Its pictures and their light are coarse; those of `make check-long` are the page's.
function blocks.run(folder, code, page, n)
  local name = ("%s_%d.lua"):format(page:gsub("[^%w]", "_"), n)
  folder:write(name, long(small(code), code))
  local command = code:find "return scene" and not code:find "^local ylm" and "bake %s -o " .. name .. ".ylm" or "run %s"
  local out, status = scratch.capture(("cd %s && YLM_LUA=%s LUA_PATH= LUA_CPATH= %s "):format(
    scratch.quote(folder.path), lua, scratch.quote(build .. "/ylm")) .. command:format(name))
  if status ~= 0 then lacking.assume() end
  assert(status == 0, page .. ", example " .. n .. "\n" .. out)
  return out
end

return blocks
