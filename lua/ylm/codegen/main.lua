--- `ylm codegen`: prints generated source, operation counts, or regenerates the tree's kernels.

local main = {}

main.usage = [[
usage: ylm codegen --lmax N [options]      print C or GLSL that evaluates spherical harmonics, N up to 150 (C in
                                           double) or 100 (GLSL; C in float); long: 1 MB at lmax 25 with Hessians
       ylm codegen --count [--lmax N]      operations of our formulas and of SCD, for each lmax to N (8)
       ylm codegen --write | --check       write, or compare, every generated file of the source tree

  --derivatives 0|1|2     gradients, Hessians too (0)
  --language c|glsl       (c)
  --solid                 solid harmonics |v|^l Y
  --unit                  for unit vectors only: fewer operations
  --method solid|scd      scd: spherical-coordinate derivatives, for comparison
  --name NAME             of the function
  -o, --output FILE       instead of standard output
  --root DIR              of the source tree, for --write and --check (.)
]]

local choices = {
  ["--derivatives"] = { "derivatives", { ["0"] = 0, ["1"] = 1, ["2"] = 2 } },
  ["--language"] = { "language", { c = "c", glsl = "glsl" } },
  ["--method"] = { "method", { solid = "solid", scd = "scd" } },
}
local flags = { ["--solid"] = "solid", ["--unit"] = "unit", ["--count"] = "count", ["--write"] = "write",
  ["--check"] = "check" }
local texts = { ["--name"] = "name", ["-o"] = "output", ["--output"] = "output", ["--root"] = "root" }

--- Tasks, and the options that have a meaning for each.
local tasks = {
  { "--check", { "--check", "--root" } },
  { "--write", { "--write", "--root" } },
  { "--count", { "--count", "--lmax", "--output" } },
  { "--lmax", { "--lmax", "--derivatives", "--language", "--solid", "--unit", "--method", "--name", "--output" } },
}

--- The first option in `given` that would be ignored: nil, or what is wrong.
local function ignored(given)
  for _, task in ipairs(tasks) do
    if given[task[1]] then
      local used = {}
      for _, word in ipairs(task[2]) do used[word] = true end
      for _, word in ipairs(given) do
        if not used[word] then return ("%s has no meaning with %s"):format(word, task[1]) end
      end
      return nil
    end
  end
end

local words = { "--lmax", "--derivatives", "--language", "--method", "--solid", "--unit", "--count", "--write", "--check",
  "--name", "--output", "--root" }

--- Options of a command line, or nil and what is wrong with it.
local function parse(args)
  local o, i = { derivatives = 0, language = "c", method = "solid", root = "." }, 1
  local given = {}
  while args[i] do
    local word, value = args[i], args[i + 1]
    local name, attached = word:match("^(%-%-[^=]+)=(.*)$")
    if name then word, value = name, attached end
    given[#given + 1] = word == "-o" and "--output" or word
    given[given[#given]] = true
    if flags[word] then
      if name then return nil, word .. " takes no value" end
      o[flags[word]] = true
    else
      if not (choices[word] or texts[word] or word == "--lmax") then
        local built, check = pcall(require, "ylm.check") -- not so before the first build
        local guess = built and check.guess(word, words)
        return nil, "unknown option " .. (built and check.short(word) or word)
          .. (guess and (" (did you mean %s?)"):format(guess) or "")
      end
      if value == nil then return nil, word .. " wants a value" end
      if not name then i = i + 1 end
      if choices[word] then
        o[choices[word][1]] = choices[word][2][value]
        if o[choices[word][1]] == nil then return nil, ("%s cannot be '%s'"):format(word, value) end
      elseif word == "--lmax" then
        o.lmax = value:match("^%d+$") and tonumber(value)
        if not o.lmax then return nil, ("--lmax must be an integer from 0 to 150, got '%s'"):format(value) end
      else o[texts[word]] = value end
    end
    i = i + 1
  end
  -- Constants grow like 2^lmax: a float holds those of 100, a double those of 150 and more. --count makes all below too.
  local highest = o.count and 30 or o.language == "glsl" and 100 or 150
  if o.lmax and o.lmax > highest then
    return nil, ("--lmax must be an integer from 0 to %d%s, got %.14g"):format(highest, o.count and " with --count"
      or o.language == "glsl" and " for glsl, whose numbers are floats" or "", o.lmax)
  end
  local useless = ignored(given)
  if useless then return nil, useless end
  if o.name and not o.name:match("^[%a_][%w_]*$") then return nil, "--name must be an identifier" end
  if o.unit and (o.solid or o.method == "scd") then
    return nil, ("--unit has no meaning with %s"):format(o.solid and "--solid" or "--method scd, which wants unit vectors itself")
  end
  if o.method == "scd" and (o.solid or not o.lmax) then return nil, "--method scd goes with --lmax and without --solid" end
  if not (o.lmax or o.count or o.write or o.check) then return nil, "--lmax is missing" end
  return o
end

local function read(path)
  local f = io.open(path, "rb")
  local text = f and f:read("*a")
  if f then f:close() end
  return text
end

--- Writes a file, whole or not at all once ylm is built.
local function write(path, text)
  local built, core = pcall(require, "ylm.c.core")
  if built and core.file_save then return core.file_save(path, text) end
  local f, message = io.open(path, "wb")
  if not f then return nil, message end
  local ok
  ok, message = f:write(text)
  if not f:close() or not ok then return nil, message or path .. ": cannot be written" end
  return true
end

--- The text of one generated file.
function main.generate(target)
  local module = require(target[2])
  return (type(module) == "table" and module.text or module)(target[3])
end

--- Compares (or writes) all targets; returns the number that differed or failed, printing their names.
local function targets(root, writes)
  local bad = 0
  for _, target in ipairs(require "ylm.codegen.targets") do
    local path, text = root .. "/" .. target[1], main.generate(target)
    if read(path) ~= text then
      if not writes then
        io.write(target[1], " is not what the generator makes: run make gen\n")
        bad = bad + 1
      else
        local ok, message = write(path, text)
        io.write(ok and target[1] or message, "\n")
        bad = bad + (ok and 0 or 1)
      end
    end
  end
  return bad
end

--- Operations of values, gradients and Hessians at unit length, ours and SCD's, as text.
function main.counts(highest)
  local source = require "ylm.codegen.source"
  local lines = { "lmax    ours: adds  muls  total    SCD: adds  muls  total (div, sqrt)   SCD/ours" }
  for lmax = 0, highest do
    local ours = source.count { lmax = lmax, derivatives = 2, unit = true }
    local scd = source.count { lmax = lmax, derivatives = 2, unit = true, method = "scd" }
    lines[#lines + 1] = ("%4d %13d %5d %6d %12d %5d %6d (%d, %d) %15s"):format(lmax, ours.adds, ours.muls, ours.total,
      scd.adds, scd.muls, scd.total, scd.divs, scd.sqrts,
      ours.total > 0 and ("%.2f"):format(scd.total / ours.total) or "-")
  end
  return table.concat(lines, "\n") .. "\n"
end

--- Runs the command with its arguments (a list); returns the exit code: 0, 1 failed, 2 bad usage.
function main.run(args)
  local o, message = parse(args)
  if not o then
    io.stderr:write("ylm codegen: ", message, "\n", main.usage)
    return 2
  end
  if o.write or o.check then return targets(o.root, o.write) == 0 and 0 or 1 end
  local text
  if o.count then text = main.counts(o.lmax or 8)
  else text = require("ylm.codegen.source").file({ o }, o.language) end
  if not o.output then
    io.write(text)
    return 0
  end
  local ok
  ok, message = write(o.output, text)
  if not ok then io.stderr:write("ylm codegen: ", message, "\n") end
  return ok and 0 or 1
end

return main
