--- ylm pathtrace scene.lua -o out.exr

local exposures = require "ylm.cli.exposures"
local report = require "ylm.cli.report"
local status = require "ylm.cli.status"

return {
  summary = "renders a scene file by paths of any length: unbiased, with its variance",
  usage = "SCENE.lua -o IMAGE",
  least = 1,
  options = {
    { "output", "-o", "FILE", "the image: .exr (with variance, to go on from), .png, .hdr or .pfm" },
    { "size", "-s", "WxH", "pixels, default that of the renderer" },
    { "samples", "-n", "N", "camera rays per pixel, in batches of 16" },
    { "bounces", "-b", "NAME", "reflections after direct light: 0, 1 .. or all (default)" },
    { "strategy", nil, "NAME", "both (default), lights or material" },
    { "tolerance", nil, "N", "end once the noise is at most this" },
    { "time-limit", nil, "N", "seconds: end after so long" },
    { "seed", nil, "N", "of all random numbers" },
    exposures.option,
    { "display", nil, "ADDRESS", "HOST:PORT of an image viewer (tev) that shows the picture while it is made" },
    { "resume", nil, "FILE", "go on from this .exr of an earlier run" },
    { "threads", "-j", "N", "default: YLM_THREADS or all cores" },
  },
  run = function(given)
    local ylm = require "ylm"
    if not given.output then status.stop(status.usage, "pathtrace: -o FILE says where the image goes") end
    status.need_output("pathtrace", given.output, "exr", "png", "hdr", "pfm")
    local exposure = exposures.of("pathtrace", given)
    local bounces = status.bounces("pathtrace", given.bounces)
    local scene = status.load_scene(given[1])
    local resume
    if given.resume then resume = status.need_kind("ylm.image", "an image", given.resume, ylm.load(given.resume)) end
    local image, facts = scene:pathtrace { size = given.size, samples = given.samples, bounces = bounces,
      strategy = given.strategy, tolerance = given.tolerance,
      time_limit = given["time-limit"], seed = given.seed, resume = resume,
      threads = given.threads, display = status.display("pathtrace", given.display),
      progress = report.progress(given) }
    status.need(image, facts)
    exposures.save(given, image, exposure)
    if facts.ended == "cancelled" then
      report.say(given, "ylm: noise is %.1f %% after %d paths a pixel; interrupted: this is the picture so far, which --resume "
        .. "of an .exr goes on from", 100 * facts.noise, facts.samples)
    end
    report.print(given, facts)
    return facts.ended == "cancelled" and status.cancelled or status.good
  end,
}
