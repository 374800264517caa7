--- ylm lightmap scene.lua -o room.glb

local lit_scene = require "ylm.cli.lit_scene"
local report = require "ylm.cli.report"
local status = require "ylm.cli.status"
local files = require "ylm.render.lightmap_file"

local quantities = { direct = true, indirect = true, all = true }

local function as_option(name, value) return value and ("--%s %s"):format(name, value) or "--" .. name end

return {
  summary = "bakes the light on a scene's surfaces into a picture with texture coordinates",
  usage = "SCENE.lua -o ROOM.glb",
  least = 1,
  options = {
    { "output", "-o", "FILE", "surfaces (.glb, .gltf, .obj) and picture, picture alone (.exr, .ktx2, .png), or page (.html)" },
    { "tolerance", "-t", "N", "of irradiance at 99 % of the surface; default 0.03, without --texels and --bytes" },
    { "texels", nil, "N", "of the picture, at most" },
    { "bytes", nil, "SIZE", "of the picture, at most (2MB, 500kB): six a texel" },
    { "quantity", nil, "NAME", "all (default), indirect (what surfaces send back, where an engine draws the lamps) or direct" },
    { "bounces", "-b", "NAME", "of --quantity indirect and all: reflections after direct light, 1, 2 .. or all (default)" },
    { "directional", nil, nil, "with the flow of light, by which normals that bumps tilt read their light: three more pictures" },
    { "picture", nil, "NAME", "exr (default) or ktx2 (half floats), or png (8 bits, with a range)" },
    { "embed", nil, nil, "the picture is in the .glb file, as .png" },
    { "lit", nil, nil, "the .glb file shows its light in any viewer" },
    { "rays", nil, "N", "of a place whose light is fitted, a multiple of 4; default 64" },
    { "seed", nil, "N", "of all random numbers; default 1" },
    { "resume", nil, "FILE", "keeps light as it is found: the command goes on from it after an interruption" },
    { "strict", nil, nil, "exit status 6 where the tolerance is not met; the files are written" },
    { "threads", "-j", "N", "default: YLM_THREADS or all cores" },
  },
  run = function(given)
    if not given.output then status.stop(status.usage, "lightmap: -o FILE says where the picture goes") end
    status.need_output("lightmap", given.output, (table.unpack or unpack)(files.endings)) -- luacheck: ignore
    if given.quantity and not quantities[given.quantity] then
      status.stop(status.usage, "lightmap: --quantity is all, indirect or direct, got '%s'", given.quantity)
    end
    local kind, why = files.kind(given.output:lower():match "%.(%w+)$", given, given.directional, as_option)
    if not kind then status.stop(status.usage, "lightmap: %s", why) end
    local scene = lit_scene.with_surfaces(given[1])
    local light = status.need(scene:lightmap { tolerance = given.tolerance, texels = given.texels,
      bytes = status.bytes("lightmap", given.bytes), quantity = given.quantity,
      bounces = status.bounces("lightmap", given.bounces), directional = given.directional,
      rays = given.rays, seed = given.seed, resume = given.resume, threads = given.threads, progress = report.progress(given) })
    local _, facts = status.need(light:save(given.output, { picture = given.picture, embed = given.embed, lit = given.lit }))
    local stats = light.stats
    stats.range, stats.exposure = facts.range, facts.exposure
    report.print(given, stats, report.names(stats, { "met", "error", "width", "height", "charts", "range" }))
    return status.of_warnings(given, { stats.warning })
  end,
}
