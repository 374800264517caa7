-- Benchmarks keep what they print: spec/bench/record, which `make bench` runs them by.

local scratch = require "spec.support.scratch"

describe("spec/bench/record", function()
  local folder
  setup(function() folder = scratch.new() end)
  teardown(function() folder:remove() end)

  local function record(docs, name, command)
    local call = "BENCH_DOCS=%s BENCH_SAYS='make bench BENCH=%s' spec/bench/record %s sh -c %s 2>&1"
    local out, status = scratch.capture(call:format(
      docs and scratch.quote(folder.path .. "/" .. docs) or "", name, name, scratch.quote(command)))
    local file = io.open(folder.path .. "/" .. (docs or "docs") .. "/" .. name .. ".md")
    local page = file and file:read "*a"
    if file then file:close() end
    return out, status, page
  end

  it("shows a table, and keeps it with command, machine, date and commit", function()
    local out, status, page = record("docs", "light", "echo 1.01 ns")
    assert.equal("1.01 ns", (out:gsub("%s+$", "")))
    assert.equal(0, status)
    for _, row in ipairs { "command", "machine", "date", "commit" } do assert.truthy(page:find("| " .. row .. " | .+ |")) end
    assert.is_true(page:find "| load before | %d" ~= nil or not io.open "/proc/loadavg")
    assert.truthy(page:find("make bench BENCH=light", 1, true))
    assert.truthy(page:find "```\n1.01 ns\n```\n$")
  end)

  it("keeps the table of before where a benchmark fails, and none without a place", function()
    record("docs", "light", "echo 1.01 ns")
    local _, status, page = record("docs", "light", "echo 2; exit 7")
    assert.equal(1, status)
    assert.truthy(page:find("1.01 ns", 1, true))
    local out, good = record(nil, "grid", "echo 3")
    assert.equal("3", (out:gsub("%s+$", "")))
    assert.equal(0, good)
    assert.falsy(io.open(folder.path .. "/docs/grid.md"))
  end)
end)
