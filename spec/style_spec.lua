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

  it("has C sources without tabs, blanks at line ends, and comments whose lines clang-format has broken", function()
    local wrong = {}
    local pipe = assert(io.popen "find csrc spec -name gen -prune -o \\( -name '*.[ch]' -o -name '*.cpp' \\) -print")
    for path in pipe:lines() do
      local n = 0
      for line in io.lines(path) do
        n = n + 1
        if line:find "\t" or line:find "%s$" or line:find "^%*[^ /*]" then wrong[#wrong + 1] = path .. ":" .. n end
      end
    end
    pipe:close()
    assert.equal("", table.concat(wrong, "\n"))
  end)
end)
