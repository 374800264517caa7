-- The man page and the completions of shells, which are made of the options that the tool parses.

local arguments = require "ylm.cli.arguments"
local commands = require "ylm.cli.commands"
local help = require "ylm.help"
local options = require "ylm.cli.options"
local scratch = require "spec.support.scratch"

local function has(program) return scratch.shell("command -v " .. program .. " >/dev/null 2>&1") end

describe("what shells know of the tool", function()
  local folder, texts
  setup(function()
    folder = scratch.new()
    texts = require "ylm.cli.completions".texts(help.names())
  end)
  teardown(function() folder:remove() end)

  --- Completions by bash of the last of the words.
  local function offers(words)
    local path = scratch.quote(folder:write("ylm.bash", texts.bash))
    local out = scratch.capture(("bash -c %s"):format(scratch.quote((". %s; compopt() { COMPREPLY=(none); }; COMP_WORDS=(%s) "
      .. "COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _ylm; echo ${COMPREPLY[*]}"):format(path,
      words))))
    return (out:gsub("%s+$", ""))
  end

  it("has every option of every command, with its short form and its value", function()
    local n = 0
    for _, row in ipairs(options.read()) do
      if not row.command.raw then
        assert.same(arguments.declared(row.command), row.options)
        for _, option in ipairs(row.options) do
          n = n + 1
          assert.truthy((texts.fish .. "\n"):find(("from %s' -l %s "):format(row.name, option[1]), 1, true)
            or (texts.fish .. "\n"):find(("from %s' -l %s\n"):format(row.name, option[1]), 1, true), row.name .. option[1])
        end
      end
    end
    assert(n > 150, n)
  end)

  it("knows the options that ylm codegen parses itself", function()
    local names = {}
    for _, row in ipairs(options.read()) do
      if row.name == "codegen" then for _, option in ipairs(row.options) do names[option[1]] = option end end
    end
    assert.same({ "c", "glsl" }, options.choices(names.language))
    assert.same({ "output", "-o", "FILE" }, { names.output[1], names.output[2], names.output[3] })
    for _, name in ipairs { "lmax", "count", "write", "check", "derivatives", "solid", "unit", "method", "name", "root" } do
      assert(names[name], name)
    end
  end)

  it("completes in bash: commands, options, choices, names that help knows; files elsewhere", function()
    assert.equal("pathtrace pack page", offers "ylm pa")
    assert.equal("--output", offers "ylm bake x.lua --out")
    assert.equal("c glsl", offers "ylm codegen --language ''")
    assert.equal("sphere_light sphere_lights", offers "ylm help sphere_l")
    assert.equal("none", offers "ylm render x.lua --samples ''")
    assert.equal("", offers "ylm render x.l")
    assert.equal("", offers "ylm render x.lua -o ''")
  end)

  it("is read without a complaint by the shells that are there", function()
    for shell, text in pairs(texts) do
      if has(shell) then
        local out, status = scratch.capture(shell .. " -n " .. scratch.quote(folder:write("x." .. shell, text)))
        assert.equal(0, status, shell .. ": " .. out)
        assert.equal("", out)
      end
    end
  end)

  it("has a man page of all commands, which man formats without a warning", function()
    local page = require "ylm.cli.manual".text "1.2.3"
    for _, name in ipairs(commands) do assert.truthy(page:find('\n.SS "ylm ' .. name .. '"\n', 1, true), name) end
    assert.truthy(page:find("\n.TP\n\\fB\\-o\\fR, \\fB\\-\\-output\\fR \\fIFILE\\fR\n", 1, true))
    if not has "groff" then pending "groff is not installed" end
    local out = scratch.capture("env -u LD_PRELOAD groff -ww -man -Tutf8 -z " .. scratch.quote(folder:write("ylm.1", page)))
    assert.equal("", out)
  end)
end)
