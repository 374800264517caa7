-- Refusals of ylm.minimise, scene:inverse_lighting and plans: see spec/refusals_spec.lua.

local nan = 0 / 0

local function bowl(x) return x[1] ^ 2, { 2 * x[1] } end

local function scene(ylm, lights)
  return ylm.scene "refusing" { geometry = ylm.box { scale = 2 },
    lights = lights or ylm.photometric_light { photometry = ylm.photometry { cosine = 1 }, at = { 0, 0.5, 0 }, name = "one" } }
end

local function target(more)
  local t = { plane = { at = { 0, -0.5, 0 }, size = { 1, 1 } }, mean = { least = 1 } }
  for key, value in pairs(more or {}) do t[key] = value end
  if more and more.none then t.mean, t.none = nil, nil end
  return { t }
end

local function given(o, says, lights)
  return { call = function(ylm)
    local all = { vary = { { dim = { 0, 1 } } }, targets = target(), judge = 0, spacing = 2, rays = 4, receiver_rays = 4 }
    for key, value in pairs(o) do all[key] = value end
    return scene(ylm, lights and lights(ylm)):inverse_lighting(all)
  end, says = says }
end

local function plan(ylm)
  return (scene(ylm):inverse_lighting { vary = { { dim = { 0, 1 } } }, targets = { { points = { { 0, -0.5, 0 } }, mean = 1 } },
    judge = 0, spacing = 2, rays = 4, receiver_rays = 4 })
end

local within = { { -1, -1, -1 }, { 1, 1, 1 } }

return {
  minimise = {
    { call = function(ylm) return ylm.minimise(5, { 1 }) end, says = "a function expected, got 5" },
    { call = function(ylm) return ylm.minimise(bowl, {}) end, says = "a list of numbers expected" },
    { call = function(ylm) return ylm.minimise(bowl, { nan }) end, says = "number 1 of x is" },
    { call = function(ylm) return ylm.minimise(bowl, { 1 }, { lower = 2, upper = 1 }) end, says = "lower 2 is above upper 1 at number 1" },
    { call = function(ylm) return ylm.minimise(bowl, { 1 }, { lower = { "a" } }) end, says = "lower must be a number, or 1 of them" },
    { call = function(ylm) return ylm.minimise(bowl, { 1 }, { evaluations = 0 }) end, says = "evaluations must be" },
    { call = function(ylm) return ylm.minimise(function() return nan, { 0 } end, { 1 }) end, says = "a finite number is wanted" },
    { call = function(ylm) return ylm.minimise(function() return 1, { nan } end, { 1 }) end, says = "number 1 of the gradient is" },
    { call = function(ylm) return ylm.minimise(function() return 1, {} end, { 1 }) end, says = "the gradient must be 1 numbers" },
  },
  ["scene:inverse_lighting"] = {
    { call = function(ylm) return scene(ylm).inverse_lighting({}) end, says = "inverse_lighting: a scene expected before the colon" },
    { call = function(ylm) return scene(ylm):inverse_lighting {} end, says = "field 'vary' is missing" },
    given({ vary = {} }, "vary is empty: what may change%?"),
    given({ vary = { {} } }, "vary%[1%]: give one of position, dim, direction, turn, colour, temperature, size"),
    given({ vary = { { dim = 1 } } }, "vary%[1%]: dim must be { least, most }, from 0 on"),
    given({ vary = { { dim = { 2, 1 } } } }, "dim must be"),
    given({ vary = { { lights = "two", dim = { 0, 1 } } } }, "no light has the name or number 'two'; there are 1, the first name is 'one'"),
    given({ vary = { { lights = 2, dim = { 0, 1 } } } }, "no light has the name or number 2"),
    given({ vary = { { position = { "x" } } } }, "position wants within"),
    given({ vary = { { position = { "w" }, within = within } } }, "'x', 'y' or 'z' expected, got 'w'"),
    given({ vary = { { position = { "x" }, within = { { 1, 0, 0 }, { 0, 0, 0 } } } } }, "within holds no place along x"),
    given({ vary = { { direction = 90 } } }, "direction must be degrees above 0, 80 at most"),
    given({ vary = { { hue = { 0, 1 } } } }, "vary%[1%]: no field 'hue'"),
    given({ vary = { { colour = { 0, 1 }, dim = { 0, 1 } } } }, "colour holds the level too"),
    given({ vary = { { size = { 2, 1 } } } }, "size must be { least, most }, from 0.001 to 1000"),
    given({ vary = { { turn = { 0, 400 } } } }, "turn must be { least, most }, from %-360 to 360"),
    given({ vary = { { temperature = { 500, 4000 } } } }, "temperature must be { least, most }, from 1001 to 24999"),
    given({ apart = 0 }, "apart must be"),
    given({ targets = target { colour = true } }, "colour is of image and of wanted: give one"),
    given({ targets = target { colour = true, wanted = { 1, 2 } } }, "wanted must be %d+ numbers for each of three channels"),
    given({ targets = {} }, "targets is empty: what is wanted%?"),
    given({ targets = target { none = true } }, "targets%[1%]: nothing is wanted"),
    given({ targets = target { mean = { least = 2, most = 1 } } }, "least 2 is above most 1"),
    given({ targets = target { mean = {} } }, "mean must be { least =, most = }"),
    given({ targets = target { mean = "bright" } }, "mean must be { least =, most = }"),
    given({ targets = target { glare = 19 } }, "targets%[1%]: glare is no target"),
    given({ targets = target { uniformity = 1 } }, "uniformity must be"),
    given({ targets = target { least = 3, most = 2 } }, "least 3 is above most 2"),
    given({ targets = target { wanted = { 1, 2 } } }, "wanted must be %d+ numbers"),
    given({ targets = target { image = 5 } }, "image must be an image, a file of one, or numbers"),
    given({ targets = target { image = { { 0, 0 } } } }, "image is dark where the receivers are"),
    given({ price = "watts" }, "price = 'watts': the photometry of light 1 has no watts"),
    given({ light_samples = 5 }, "light_samples and rim must be even"),
    given({}, "light 1 is a textured_light, whose dim does not vary", function(ylm)
      return ylm.textured_light { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 }, image = { { 1 } } }
    end),
    given({ vary = { { position = { "x" }, within = within } } }, "light 1 is a point: the shadow of a point", function(ylm)
      return ylm.spot_light { at = { 0, 0, 0 }, to = { 0, -1, 0 }, angle = 30 }
    end),
    given({ vary = { { position = { "x" }, within = within } } }, "light 1 is a point: give it an opening", function(ylm)
      return ylm.photometric_light { photometry = ylm.photometry { cosine = 1 }, at = { 0, 0, 0 }, opening = "point" }
    end),
    given({ vary = { { direction = 20 } } }, "light 1 is a sphere_light, whose direction does not vary", function(ylm)
      return ylm.sphere_light { at = { 0, 0, 0 } }
    end),
    { call = function(ylm)
      local other = scene(ylm):links { spacing = 2, rays = 4 }
      return scene(ylm):inverse_lighting { links = other, vary = { { dim = { 0, 1 } } }, targets = target() }
    end, says = "the links are of another scene" },
  },
  ["plan:figure"] = {
    { call = function(ylm) return plan(ylm).figure({}) end, says = "figure: a plan expected before the colon" },
    { call = function(ylm) return plan(ylm):figure() end, says = "figure: no target is a plane or a lightmap" },
    { call = function(ylm) return plan(ylm):figure { width = 1 } end, says = "width must be" },
  },
  ["plan:save"] = {
    { call = function(ylm) return plan(ylm).save({}) end, says = "save: a plan expected before the colon" },
    { call = function(ylm) return plan(ylm):save "plan.txt" end, says = "a file name that ends in .lua expected, got 'plan.txt'" },
    { call = function(ylm) return plan(ylm):save "no such folder/plan.lua" end, says = "no such folder" },
  },
}
