--- Transfer vectors and matrices of prepared views: view:transfer, view:matrices.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local form = require "ylm.form"
local objects = require "ylm.transfer.object"
local options = require "ylm.render.options"
local progress = require "ylm.progress"
local vectors = require "ylm.transfer.vectors"
local views = require "ylm.render.view"
local visibility = require "ylm.render.visibility"

local prepared = views.methods

local MOST = 2 ^ 31 -- bytes of all matrices of a view

local transfer_fields = options.list({
  { "links", "object", of = "ylm.links", optional = true,
    about = "elements and links of the view's scene (scene:links): vectors with bounces, by rays that know no "
      .. "occlusion_distance. Without it the view's own vectors are returned, and other options are refused" },
  { "rays", "links", default = 128, about = "of a shading point, a multiple of 4" },
}, vectors.options, { { "seed", "integer", min = 0, max = core.limits.seed, default = 1, about = "of these rays" } })

describe "view:transfer" {
  about = "The transfer vectors of a prepared view: SH coefficients of cosine times visibility, or with them what surfaces send "
    .. "on. With links they hold bounces of light that is the same everywhere (a sky, a sun); lamps in a room are not: see "
    .. "links:radiosity. Without one the view was prepared with visibility = 'transfer' or 'none'.",
  arguments = { { "options?", "table", "" } },
  options = transfer_fields,
  returns = {
    { "T", "array", "float [n][(lmax+1)^2]; with links [n][3][(lmax+1)^2], lmax that of the links. Radiance is albedo / "
      .. "pi times its product with light" },
    { "stats", "table", "with links: " .. vectors.stats_text },
  },
  errors = "raises on what is no prepared view, links of other geometry, and bounces that do not converge; nil, message, "
    .. "code: memory, cancelled",
  example = options.one_lamp .. [[
local view = scene:prepare { size = { 32, 18 }, samples = 1, lmax = 2, visibility = "transfer" }
assert(view:transfer().shape[2] == 9)
local T = view:transfer { links = scene:links { rays = 16 }, bounces = 1 }
assert(T.shape[2] == 3 and T.shape[3] == 25)]],
  source = "Green 2003, \"Diffuse Interreflected Transfer\"; Sloan et al. 2002",
}
function prepared.transfer(view, given)
  local p = views.open("transfer", view)
  local o = form.options(1, "transfer", transfer_fields, given)
  if not o.links then
    local name = next(given or {})
    if name then return check.fail("transfer: %s is for vectors with bounces: give links (scene:links)", name) end
    visibility.need_transfer("transfer", p)
    if p.options.gloss ~= "matte" and p.traced.glossy > 0 then
      return check.fail 'transfer: glossy surfaces have no transfer vectors but as matte ones: prepare with gloss = "matte"'
    end
    return check.result("transfer", p.lib.shade_transfer(p.view))
  end
  local m, show = objects.of_view("transfer", p, o.links), progress.resolve(o.progress)
  local of, stats, code = vectors.arriving("transfer", o.links, m, o, show)
  if of == nil then return nil, stats, code end
  local T, message
  T, message, code = check.result("transfer", p.lib.shade_vectors(p.view, o.links, of or nil, o.rays, o.seed, o.threads,
    show))
  if not T then return nil, message, code end
  return T, stats
end

local matrix_fields = options.list({
  { "links", "object", of = "ylm.links", about = "elements and links of the view's scene (scene:links)" },
  { "lmax_in", "integer", min = 0, max = core.limits.transfer_lmax, optional = true,
    about = "of the distant light; default and most: that of the links" },
  { "lmax_out", "integer", min = 0, max = core.limits.transfer_lmax, optional = true,
    about = "of the light that arrives; default: lmax_in" },
  { "rays", "integer", min = 1, max = core.limits.light_samples, default = 512,
    about = "of a shading point, even over the hemisphere" },
}, vectors.options, { { "seed", "integer", min = 0, max = core.limits.seed, default = 1, about = "of these rays" } })

--- A number of bytes in words.
local function in_words(bytes)
  if bytes >= 2 ^ 30 then return ("%.1f GiB"):format(bytes / 2 ^ 30) end
  return ("%.0f MiB"):format(math.max(1, bytes / 2 ^ 20))
end

describe "view:matrices" {
  about = "The transfer matrices of a prepared view: from distant light to the light that arrives at each shading point, as "
    .. "coefficients of incident radiance above its horizon, straight and by way of other surfaces. sh.apply applies "
    .. "them. At most 2 GiB; what they hold is in links too, in 2 or 4 bytes a link.",
  arguments = { { "options", "table", "links are needed" } },
  options = matrix_fields,
  returns = {
    { "M", "array", "float [n][3][(lmax_out+1)^2][(lmax_in+1)^2]" },
    { "stats", "table", vectors.stats_text },
  },
  errors = "raises on a bad option, matrices of more than 2 GiB, links of other geometry; nil, message, code: memory, "
    .. "cancelled",
  example = options.one_lamp .. [[
local view = scene:prepare { size = { 16, 9 }, samples = 1 }
local M = view:matrices { links = scene:links { rays = 16 }, lmax_in = 2, lmax_out = 3, rays = 64 }
assert(M.shape[2] == 3 and M.shape[3] == 16 and M.shape[4] == 9)
local incident = ylm.sh.apply(M, { 1, 0, 0, 0, 0, 0, 0, 0, 0 })
assert(incident.shape[2] == 3 and incident.shape[3] == 16)]],
  source = "Green 2003, \"transfer matrices\"; Sloan et al. 2002; Lehtinen & Kautz 2003",
}
function prepared.matrices(view, given)
  local p = views.open("matrices", view)
  local o = form.options(1, "matrices", matrix_fields, given)
  local m, show = objects.of_view("matrices", p, o.links), progress.resolve(o.progress)
  local into = o.lmax_in or m.stats.lmax
  local out = o.lmax_out or into
  if into > m.stats.lmax then
    return check.fail("matrices: lmax_in %d, and the links know light to lmax %d (lmax = in scene:links)", into,
      m.stats.lmax)
  end
  local n = p.stats.points
  local bytes = n * 12 * (into + 1) ^ 2 * (out + 1) ^ 2
  if bytes > MOST then
    return check.fail("matrices: %d shading points would take %s, more than 2 GiB: use fewer points or a lower lmax, or links: "
      .. "view:transfer { links = t } takes %s, and t:radiosity(lights) follows any light", n, in_words(bytes),
      in_words(n * 12 * (m.stats.lmax + 1) ^ 2))
  end
  local of, stats, code = vectors.arriving("matrices", o.links, m, o, show)
  if of == nil then return nil, stats, code end
  local M, message
  M, message, code = check.result("matrices", p.lib.shade_matrices(p.view, o.links, of or nil,
    { rays = o.rays, seed = o.seed, lmax_in = into, lmax_out = out, threads = o.threads, progress = show }))
  if not M then return nil, message, code end
  return M, stats
end

return prepared
