-- Code in README.md and docs runs as it stands; cited works are listed; links lead somewhere.

local scratch = require "spec.support.scratch"

local build = os.getenv "YLM_BUILD" or "build"
local lua = os.getenv "YLM_LUA" or "lua5.4"
local root = scratch.capture "pwd":gsub("%s+$", "")
if not build:find "^/" then build = root .. "/" .. build end

local function lines_of(command)
  local list, pipe = {}, assert(io.popen(command))
  for line in pipe:lines() do list[#list + 1] = line end
  pipe:close()
  return list
end

local function read(path)
  local file = assert(io.open(path, "rb"))
  local text = file:read "*a"
  file:close()
  return text
end

local pages = lines_of "ls README.md docs/*.md"

describe("the documentation", function()
  local folder
  setup(function() folder = scratch.new() end)
  teardown(function() folder:remove() end)

  for _, page in ipairs(pages) do
    local number = 0
    for language, code in (read(page) .. "\n"):gmatch("```(%w+)\n(.-)```") do
      if language == "lua" then
        number = number + 1
        local n, name = number, ("%s_%d.lua"):format(page:gsub("[^%w]", "_"), number)
        it(("runs: %s, example %d"):format(page, n), function()
          folder:write(name, code)
          local command = code:find "return scene" and "bake %s -o " .. name .. ".ylm" or "run %s"
          local out, status = scratch.capture(("cd %s && YLM_LUA=%s LUA_PATH= LUA_CPATH= %s "):format(
            scratch.quote(folder.path), lua, scratch.quote(build .. "/ylm")) .. command:format(name))
          assert(status == 0, page .. ", example " .. n .. "\n" .. out)
        end)
      end
    end

    it("leads somewhere: links of " .. page, function()
      local here = page:match("^(.*/)") or ""
      for target in read(page):gmatch("%]%(([^)#]+)") do
        if not target:find "^https?:" then
          assert(scratch.shell("test -e " .. scratch.quote(here .. target)), page .. ": no " .. target)
        end
      end
    end)
  end

  it("lists every work that is cited", function()
    local entries, missing, cited = {}, {}, 0
    for entry in (read "docs/references.md":gsub("\n%- ", "\n\0") .. "\0"):gmatch("(%Z+)") do
      entries[#entries + 1] = entry
    end
    local function is_listed(name, year)
      for _, entry in ipairs(entries) do
        if entry:find(name, 1, true) and entry:find(year, 1, true) then return true end
      end
    end
    local lines = lines_of("grep -rnE '[Ss]ources? .*(19|20)[0-9]{2}' csrc lua "
      .. "--include=*.h --include=*.c --include=*.cpp --include=*.lua")
    for _, line in ipairs(lines) do
      local text = line:match("[Ss]ources? +(.*)$")
      for name, year in text:gmatch("(%u[%a']+)[%s%a&.]- ([12][90]%d%d)%f[%D]") do
        cited = cited + 1
        if not is_listed(name, year) then missing[#missing + 1] = name .. " " .. year .. ": " .. line end
      end
    end
    assert(cited > 0)
    assert.equal("", table.concat(missing, "\n"))
  end)
end)
