--- team:each: cases of a sweep, one after another to whoever is free.

local check = require "ylm.check"
local core = require "ylm.c.core"
local form = require "ylm.form"
local journal = require "ylm.team.journal"
local memory = require "ylm.memory"
local progress = require "ylm.progress"
local values = require "ylm.team.values"

local each = {}

each.options = {
  { "journal", "path", optional = true, about = "a file that keeps each result as soon as it is there: a sweep that is started "
    .. "again does the cases that it lacks. Results belong to a case, not to its number; where the function has changed, "
    .. "remove the file" },
  { "progress", "progress", optional = true,
    about = "called as f(done, total, stage) on the first process between its cases; returning false ends the sweep" },
}

--- Runs a case? Its function may not divide work again.
local within = false

--- Checksums of the cases: the keys of their results in a journal.
local function keys_of(cases)
  local keys = {}
  for i, case in ipairs(cases) do
    local text, message = values.encode(case, ("case %d"):format(i))
    if not text then
      return check.bad(1, "each", "journal: cases are numbers, strings, booleans, arrays and tables of these; %s", message)
    end
    keys[i] = core.team_crc(text)
  end
  return keys
end

--- The text of a case's result; or nil, message, code, and the error where one was raised.
local function outcome(i, ok, first, message, code)
  if not ok then
    local words = memory.message(first)
    if words then return nil, words, "ENOMEM" end
    return nil, tostring(first), "EINVAL", { first }
  end
  if first == nil and type(message) == "string" then
    return nil, ("case %d: %s"):format(i, message), type(code) == "string" and code or "EPEER"
  end
  if first == nil then first = true end
  local text, why = values.encode(first, "the result")
  if text then return text end
  why = ("each: case %d: results are numbers, strings, booleans, arrays and tables of these; %s"):format(i, why)
  return nil, why, "EINVAL", { check.position() .. why }
end

local function run_case(f, case, i)
  within = true
  local text, message, code, raised = outcome(i, pcall(f, case, i))
  within = false
  return text, message, code, raised
end

--- Results in the journal, the same for every process: texts by key. Or nil, message, code.
local function known(team, path)
  local found, parts, code, joined
  if team.rank == 1 then
    found, parts, code = journal.read(path)
    if found then joined, parts, code = journal.join(path, found, parts) end
  end
  local good, message = true, nil
  if team.rank == 1 and not joined then good, message = nil, parts end
  good, message, code = core.team_agree(team.handle, not good and code or nil, message)
  if not good then return nil, message, code end
  local lists
  lists, message, code = core.team_exchange(team.handle, values.encode(found or {}, "the journal"))
  if not lists then return nil, message, code end
  return values.decode(lists[1])
end

--- The cases that are left do, until none is: texts by place. Or nil, message, code, error.
local function share(team, cases, f, left, keep, report)
  local job, done = core.team_job(team.handle), {}
  while true do
    local task, message, code = core.team_next(team.handle, job, #left)
    if task == nil then return nil, message, code end
    if not task then return done end
    local i, good = left[task], true
    local text, raised
    if report and report(task - 1, #left, "cases") == false then message, code = "cancelled", "ECANCELLED"
    else text, message, code, raised = run_case(f, cases[i], i) end
    if text and keep then good, message, code = keep(i, text) end
    if not text or not good then
      core.team_stop(team.handle, job)
      return nil, message, code, raised
    end
    done[#done + 1] = { i, text }
  end
end

--- Raises what the caller has done wrong; returns the rest: nil, message, code.
local function fail(message, code, raised)
  if raised then error(raised[1], 0) end
  if core.status(code) == "caller" then error(message, 0) end
  return nil, message, code
end

local function open_journal(team, path)
  local j, message, code = journal.open(path, team.rank)
  local good, why, whose = core.team_agree(team.handle, not j and code or nil, message)
  if good then return j end
  if j then journal.close(j) end
  return nil, why, whose
end

--- Every process's results; then one file has all that a journal keeps, `found` before too. Or nil, message, code.
local function collect(team, done, texts, keys, found, path)
  local lists, message, code = core.team_exchange(team.handle, values.encode(done, "results"))
  if not lists then return nil, message, code end
  for _, list in ipairs(lists) do
    for _, one in ipairs(values.decode(list)) do texts[one[1]] = one[2] end
  end
  if path then
    local good = true
    if team.rank == 1 then
      for i, text in pairs(texts) do found[keys[i]] = text end
      good, message, code = journal.join(path, found, team.size)
    end
    good, message, code = core.team_agree(team.handle, not good and code or nil, message)
    if not good then return nil, message, code end
  end
  return texts
end

--- Results known by key, by place; and the places of the cases that are left.
local function sorted(cases, keys, found)
  local texts, left = {}, {}
  for i = 1, #cases do
    texts[i] = keys and found[keys[i]]
    if not texts[i] then left[#left + 1] = i end
  end
  return texts, left
end

--- team:each. `team`: rank, size, handle.
function each.run(team, cases, f, given)
  if within then return check.fail("each: a function of team:each cannot divide work again") end
  if type(cases) ~= "table" or getmetatable(cases) ~= nil then
    return check.bad(1, "each", "a list of cases expected, got %s", check.describe(cases))
  end
  if type(f) ~= "function" then return check.bad(2, "each", "a function(case, i) expected, got %s", check.describe(f)) end
  local o = form.options(3, "each", each.options, given)
  local keys = o.journal and keys_of(cases)
  local same, message, code = core.team_same(team.handle, "", { "number of cases", "journal", "list of cases" },
    { tostring(#cases), o.journal or "", keys and table.concat(keys) or "" })
  if not same then return check.result("each", nil, message, code) end
  local found, keep, j = {}, nil, nil
  if o.journal then
    found, message, code = known(team, o.journal)
    if not found then return nil, message, code end
  end
  local texts, left = sorted(cases, keys, found)
  if o.journal then
    j, message, code = open_journal(team, o.journal)
    if not j then return nil, message, code end
    keep = function(i, text) return journal.add(j, keys[i], text) end
  end
  local report = team.rank == 1 and progress.resolve(o.progress) or nil
  local done, raised
  done, message, code, raised = share(team, cases, memory.users(f), left, keep, report)
  if j then journal.close(j) end
  local good
  good, message, code = core.team_agree(team.handle, not done and code or nil, message)
  if not good then return fail(message, code, raised) end
  texts, message, code = collect(team, done, texts, keys, found, o.journal)
  if not texts then return nil, message, code end
  if report then report(#left, #left, "cases") end
  local results = {}
  for i = 1, #cases do results[i] = values.decode(texts[i]) end
  return results
end

return each
