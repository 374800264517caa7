-- Refusals of transfer vectors with bounces and of transfer matrices: see spec/refusals_spec.lua.

local function scene(ylm, albedo)
  return ylm.scene "refusing" {
    camera = ylm.camera { from = { 0, 0, 0.4 }, at = { 0, 0, 0 }, up = { 0, 1, 0 }, fov = 90 },
    geometry = { ylm.box { scale = 2, material = ylm.matte { albedo = albedo or 0.5 } } },
    lights = ylm.sphere_light { at = { 0, 0, 0 }, radius = 0.1 },
  }
end

local function links(ylm, albedo, lmax) return scene(ylm, albedo):links { spacing = 4, rays = 4, lmax = lmax } end

local function vectors(o, says) return { call = function(ylm) return links(ylm):vectors(o) end, says = says } end

--- Method `name` of a view of the same scene as its links, which are of degree 2.
local function viewed(name, o, says, size, lmax)
  return { call = function(ylm)
    local s, given = scene(ylm), {}
    for key, value in pairs(o) do given[key] = value end
    given.links = s:links { spacing = 4, rays = 4, lmax = lmax or 2 }
    local view = s:prepare { size = size or { 2, 2 }, samples = 1 }
    return view[name](view, given)
  end, says = says }
end

local function of_another(name)
  return { call = function(ylm)
    local view = scene(ylm):prepare { size = { 2, 2 }, samples = 1 }
    return view[name](view, { links = links(ylm) })
  end, says = name .. ": the links are of other geometry, that of scene \"refusing\"" }
end

local function closed(name)
  return { call = function(ylm)
    local s = scene(ylm)
    local view, t = s:prepare { size = { 2, 2 }, samples = 1 }, s:links { spacing = 4, rays = 4 }
    t:close()
    return view[name](view, { links = t })
  end, says = name .. ": the links have been closed" }
end

return {
  ["links:vectors"] = {
    { call = function(ylm) return links(ylm).vectors {} end, says = "vectors: links expected before the colon" },
    { call = function(ylm)
      local t = links(ylm)
      t:close()
      return t:vectors()
    end, says = "vectors: the links have been closed" },
    vectors({ bounces = -1 }, "bounces must be"), vectors({ residual = 0 }, "residual must be"),
    vectors({ object = 0 }, "object must be"), vectors({ object = 2 }, "object must be from 1 to 1, .* got 2"),
    vectors({ objects = 1 }, "did you mean 'object'"), vectors({ progress = function() return false end }, "cancelled"),
    { call = function(ylm)
      local s = ylm.scene "open" { geometry = ylm.quad { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 0, -1 } } }
      return s:links({ rays = 4 }):vectors { threads = 0 }
    end, says = "threads must be" },
  },
  ["view:transfer"] = {
    viewed("transfer", { rays = 6 }, "rays must be a multiple of 4"), viewed("transfer", { bounces = "many" }, "bounces must be"),
    viewed("transfer", { residual = 2 }, "residual must be"), viewed("transfer", { lmax = 2 }, "no field 'lmax'"),
    of_another "transfer", closed "transfer",
    { call = function(ylm) return scene(ylm):prepare({ size = { 2, 2 }, samples = 1 }):transfer { links = 1 } end,
      says = "links must be a ylm.links, got 1" },
    { call = function(ylm) return scene(ylm):prepare({ size = { 2, 2 }, samples = 1 }):transfer { bounces = 1 } end,
      says = "bounces is for vectors with bounces: give links" },
  },
  ["view:render"] = {
    { call = function(ylm) return scene(ylm):prepare({ size = { 2, 2 }, samples = 1 }):render { vectors = ylm.zeros { 4, 3 } } end,
      says = "render: vectors must be %[%d%]%[3%].* got 4x3" },
    { call = function(ylm)
      local view = scene(ylm):prepare { size = { 2, 2 }, samples = 1 }
      return view:render { vectors = ylm.zeros { view.stats.points, 3, 9 }, lights = 4 }
    end, says = "a light or a list of lights expected, got 4" },
    { call = function(ylm)
      local view = scene(ylm):prepare { size = { 2, 2 }, samples = 1 }
      return view:render { vectors = ylm.zeros { view.stats.points, 3, 9 }, progress = function() return false end }
    end, says = "cancelled" },
  },
  ["view:matrices"] = {
    { call = function(ylm) return scene(ylm):prepare({ size = { 2, 2 }, samples = 1 }).matrices {} end,
      says = "matrices: a prepared view expected" },
    { call = function(ylm) return scene(ylm):prepare({ size = { 2, 2 }, samples = 1 }):matrices() end,
      says = "field 'links' is missing" },
    viewed("matrices", { lmax_in = 3 }, "lmax_in 3, and the links know light to lmax 2"),
    viewed("matrices", { lmax_in = 21 }, "lmax_in must be"), viewed("matrices", { lmax_out = -1 }, "lmax_out must be"),
    viewed("matrices", { rays = 0 }, "rays must be"), viewed("matrices", { lmax_out = 20 },
      "3881 shading points would take 2.3 GiB, more than 2 GiB: .* or links: view:transfer .* takes", { 64, 64 }, 10),
    of_another "matrices", closed "matrices",
  },
}
