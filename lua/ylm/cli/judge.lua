--- ylm judge scene.lua room.three.json ...

local report = require "ylm.cli.report"
local status = require "ylm.cli.status"

local PLACES = { 160, 90 } -- of a picture

--- { { x, y, z }, { x, y, z } } of "x,y,z,x,y,z"; nil: none were given.
local function bounds_of(text)
  if text == nil then return nil end
  local x = {}
  for word in text:gmatch "[^,]+" do x[#x + 1] = tonumber(word) end
  if #x ~= 6 then status.stop(status.usage, "judge: --bounds is six numbers, x,y,z,x,y,z, got '%s'", text) end
  return { { x[1], x[2], x[3] }, { x[4], x[5], x[6] } }
end

--- Pictures below one another, as one.
local function stacked(ylm, pictures)
  if #pictures == 1 then return pictures[1] end
  local w, h = 0, 0
  for _, one in ipairs(pictures) do w, h = math.max(w, one.size[1]), h + one.size[2] end
  local all, y = status.need(ylm.image { size = { w, h } }), 1
  for _, one in ipairs(pictures) do
    all:paste(one, 1, y)
    y = y + one.size[2]
  end
  return all
end

return {
  summary = "files of probes beside paths: the error at the surfaces of their scene",
  usage = "SCENE.lua PROBES...   (.ylmp, .three.json, .ktx2, .npy, .ylm, .surfaces)",
  least = 2,
  options = {
    { "quantity", nil, "NAME", "the light that they hold: indirect (default) or all" },
    { "places", nil, "N", "of surfaces, default 1000" },
    { "samples", "-n", "N", "paths from each, default 2048" },
    { "bounds", nil, "BOX", "of .npy: x,y,z,x,y,z" },
    { "offset", nil, "N", "of .npy: cells off the surface that its engine looks up" },
    { "seed", nil, "N", "of places and paths" },
    { "output", "-o", "FILE", "a picture (.png, .exr): what the camera sees by paths, by each file, and the error" },
    { "size", "-s", "WxH", "places of the picture, default 160x90" },
    { "threads", "-j", "N", "default: YLM_THREADS or all cores" },
  },
  run = function(given)
    local ylm = require "ylm"
    if given.output then status.need_output("judge", given.output, "png", "exr") end
    if given.size and not given.output then status.stop(status.usage, "judge: --size is of a picture: name one with -o") end
    local scene, pictures = status.load_scene(given[1]), {}
    if given.output and not scene.camera then
      status.stop(status.usage, "judge: -o: the scene has no camera, and its picture is what that sees")
    end
    for k = 2, #given do
      local path = given[k]
      local what = path
      if status.is_surfaces(path) then what = status.need(scene:surface_grid { file = path })
      elseif path:lower():find "%.ylm$" then what = status.need_kind("ylm.grid", "a grid", path, ylm.load(path)) end
      local r = status.need(scene:judge(what, { quantity = given.quantity, places = given.places, samples = given.samples,
        bounds = bounds_of(given.bounds), offset = given.offset, seed = given.seed, threads = given.threads,
        picture = given.output and (given.size or PLACES) or nil, progress = report.progress(given) }))
      pictures[#pictures + 1] = r.picture
      local at = r.worst.at
      local results = { file = path, rms = r.rms, error = r.error, leak = r.leak, negative = r.negative, noise = r.noise,
        bytes = r.bytes,
        worst = ("%.3g at %.3g, %.3g, %.3g"):format(r.worst.error, at[1], at[2], at[3]) }
      report.print(given, results, report.names(results, { "file", "bytes", "rms", "error" }))
    end
    if given.output then status.need(stacked(ylm, pictures):save(given.output, { exposure = 0 })) end
  end,
}
