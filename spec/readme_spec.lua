-- Code in README.md and docs runs as it stands; cited works are listed; links lead somewhere. (spec/guide_spec.lua runs the
-- tutorial and the questions, spec/documentation_spec.lua the examples of the reference.)

local scratch = require "spec.support.scratch"

local blocks = require "spec.support.blocks"

local lines_of = scratch.lines

local read = scratch.text

local pages = lines_of "ls *.md docs/*.md"
local elsewhere = { ["docs/tutorial.md"] = true, ["docs/how-do-i.md"] = true, ["docs/api.md"] = true }

describe("the documentation", function()
  local folder
  setup(function() folder = scratch.new() end)
  teardown(function() folder:remove() end)

  for _, page in ipairs(pages) do
    if not elsewhere[page] then
      for n, code in ipairs(blocks.of(read(page))) do
        it(("runs: %s, example %d"):format(page, n), function() blocks.run(folder, code, page, n) end)
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
    -- Comments and strings of the sources, and the text of documents: "Name 2001", "Name & Other (2001)",
    -- "Name, Other and Third 2001", "Name et al. 2001". Any of the names will do.
    local files = "csrc lua examples docs README.md CHANGELOG.md --include=*.h --include=*.c --include=*.cpp "
      .. "--include=*.lua --include=*.md"
    local lines = lines_of("grep -rnE '(19|20)[0-9]{2}' " .. files .. " | grep -v -e /gen/ -e docs/references.md")
    local link = { ["and"] = true, ["&"] = true, ["et"] = true, ["al."] = true }
    for _, line in ipairs(lines) do
      local words, text = {}, line:match "^[^:]*:%d+:(.*)$"
      for word in text:gmatch "%S+" do
        local year = word:match "^%(?([12][90]%d%d)[%p]*$"
        if year then
          local names, k = {}, #words
          local bare = k > 0 and words[k]:gsub(",$", "")
          while k > 0 and (bare:find "^[%(\"]*%u[%a'\128-\255-]+$" or link[bare]) do
            if not link[bare] then names[#names + 1] = bare:match "%u.*" end
            k = k - 1
            bare = k > 0 and words[k]:gsub(",$", "")
          end
          if #names > 0 then
            cited = cited + 1
            local listed = false
            for _, name in ipairs(names) do listed = listed or is_listed(name, year) end
            if not listed then missing[#missing + 1] = names[1] .. " " .. year .. ": " .. line end
          end
        end
        words[#words + 1] = word
      end
    end
    assert(cited > 60, cited)
    assert.equal("", table.concat(missing, "\n"))
  end)
end)
