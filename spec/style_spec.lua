-- The tree's own style, and that what is generated is what the generators make.

local scratch = require "spec.support.scratch"

describe("the tree", function()
  if os.getenv "YLM_LUA" == "luajit" then return end -- once is enough

  it("passes luacheck", function()
    if not scratch.shell "command -v luacheck >/dev/null" then pending "luacheck is not installed" end
    local out, code = scratch.capture "luacheck --no-color -q ."
    assert(code == 0, out)
  end)

  it("holds the kernels that the generator makes (make gen)", function()
    local out, code = scratch.capture "env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make -s --no-print-directory gen-check"
    assert(code == 0, out)
  end)

  -- Headers that generated kernels include, mended when these are compiled again for another reason.
  local later = { ["csrc/sh/ylm_sh.h"] = true, ["csrc/light/ylm_light.h"] = true }

  -- The lines of a C file that a reflow of comments has torn: the end of a comment of one line, alone
  -- on the next; a word or two of a paragraph, before a line that they would fit into.
  local function torn(lines)
    local found, opened = {}, nil
    for n, line in ipairs(lines) do
      if line:find "/%*" then opened = n end
      local text, following = line:match "^%*%* (%S.*)$", (lines[n + 1] or ""):match "^%*%* ([%l(]%S*)"
      if line:find "^%s*%*/$" and not lines[opened]:find "^%s*/%*%*?$"
         or text and following and #text + #following < 60 and text:find "[%w,]$" and not text:find "  " then
        found[#found + 1] = n
      end
    end
    return found
  end

  it("has C sources without tabs, blanks at line ends, and comments whose lines were broken by a reflow", function()
    local wrong = {}
    local pipe = assert(io.popen "find csrc spec -name gen -prune -o \\( -name '*.[ch]' -o -name '*.cpp' \\) -print")
    for path in pipe:lines() do
      local lines = {}
      for line in io.lines(path) do
        lines[#lines + 1] = line
        if line:find "\t" or line:find "%s$" or line:find "^%*[^ /*]" then wrong[#wrong + 1] = path .. ":" .. #lines end
      end
      for _, n in ipairs(later[path] and {} or torn(lines)) do wrong[#wrong + 1] = path .. ":" .. n end
    end
    pipe:close()
    assert.equal("", table.concat(wrong, "\n"))
  end)
end)
