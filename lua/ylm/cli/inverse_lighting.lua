--- ylm inverse_lighting scene.lua -o planned.lua

local report = require "ylm.cli.report"
local status = require "ylm.cli.status"

--- Results as a line for each target; as they are for --json.
local function shown(given, results)
  if given.json then return results, report.names(results, { "met", "targets" }) end
  local out, order = {}, { "met" }
  for key, value in pairs(results) do if key ~= "targets" then out[key] = value end end
  for i, t in ipairs(results.targets) do
    local name = t.name or ("target %d"):format(i)
    out[name] = ("%s: mean %.0f lx, least %.0f, most %.0f, U0 %.3f%s, by %s"):format(t.met and "met" or "not met", t.mean,
      t.least, t.most, t.uniformity, t.rms and (", rms %.3f"):format(t.rms) or "", t.judged)
    order[#order + 1] = name
  end
  for _, name in ipairs { "evaluations", "ended", "lumens", "lumens_before" } do order[#order + 1] = name end
  return out, report.names(out, order)
end

return {
  summary = "finds lamps for the light that a scene file asks for, judged by paths",
  usage = "SCENE.lua [-o PLANNED.lua] [--figure OUT.png]    SCENE.lua has a table inverse_lighting = { vary =, targets = }",
  least = 1,
  most = 1,
  options = {
    { "output", "-o", "FILE", "the planned scene as .lua, its surfaces (.glb) and photometries (.ies) beside it" },
    { "figure", nil, "FILE", "maps before and after, and curves of the search (.png)" },
    { "evaluations", nil, "N", "of light and its derivatives, at most; default 40" },
    { "starts", nil, "N", "further ones with places moved at random; the best is kept; default 1" },
    { "judge", nil, "N", "paths of each place that judge the result; default 4096" },
    { "seed", nil, "N", "of all random numbers; default 1" },
    { "strict", nil, nil, "exit status 6 where not everything that is asked for is met; the files are written" },
    { "threads", "-j", "N", "default: YLM_THREADS or all cores" },
  },
  run = function(given)
    if given.output then status.need_output("inverse_lighting", given.output, "lua") end
    if given.figure then status.need_output("inverse_lighting", given.figure, "png") end
    local scene = status.load_scene(given[1])
    local o = {}
    for name, value in pairs(scene.inverse_options or {}) do o[name] = value end
    if next(o) == nil then
      status.stop(status.script, "%s: the scene has no table inverse_lighting = { vary =, targets = }", given[1])
    end
    for _, name in ipairs { "evaluations", "starts", "judge", "seed", "threads" } do o[name] = given[name] or o[name] end
    o.progress = report.progress(given)
    local plan, results, code = scene:inverse_lighting(o)
    status.need(plan, results, code)
    report.print(given, shown(given, results))
    if given.output then status.need(plan:save(given.output)) end
    if given.figure then status.need(plan:figure():save(given.figure)) end
    return status.of_warnings(given, { not results.met and "what the scene asks for is not met" or nil })
  end,
}
