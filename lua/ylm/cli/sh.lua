--- ylm sh ENVIRONMENT: its spherical harmonics in the convention of an engine, as text, JSON, code or .npy.

local check = require "ylm.check"
local core = require "ylm.c.core"
local report = require "ylm.cli.report"
local sh_code = require "ylm.cli.sh_code"
local status = require "ylm.cli.status"

local formats = { "text", "json", "glsl", "c", "lua", "npy" }
local mappings = core.choices "mapping"

--- Systems whose numbers are irradiance over pi.
local is_irradiance = { unity = true, filament = true }

--- Systems whose coefficients stand before their channels.
local channels_last = { ["three.js"] = true, filament = true, ["3dgs"] = true }

--- An option's value, one of `list`.
local function choice(name, value, list)
  for _, word in ipairs(list) do if value == word then return value end end
  local guess = check.guess(value, list)
  status.stop(status.usage, "sh: --%s is one of %s, got '%s'%s", name, table.concat(list, ", "), check.short(value),
    guess and (" (did you mean '%s'?)"):format(guess) or "")
end

--- The convention that is asked for, as ylm writes its name: with "irradiance" where that is asked for and not meant anyway.
local function convention_of(given)
  local text = given.as or "ylm"
  local systems = require "ylm.sh.convert".systems
  local number, message = core.sh_convention(text)
  if number and given.irradiance and not is_irradiance[core.sh_convention_name(number):match "^%S+"]
    and not text:find "irradiance" then
    number, message = core.sh_convention(text:gsub("^(%S+)", "%1 irradiance", 1))
  end
  if number then return core.sh_convention_name(number) end
  local guess = check.guess(text:match "^%S*", systems)
  status.stop(status.usage, "sh: --as: %s%s", message, guess and (" (did you mean '%s'?)"):format(guess) or "")
end

--- The mapping that is asked for, or the first that fits the image's size.
local function mapping_of(given, path, size)
  if given.mapping then choice("mapping", given.mapping, mappings) end
  for _, mapping in ipairs(given.mapping and { given.mapping } or mappings) do
    if core.mapping_fits(mapping, size[1], size[2]) then return mapping end
  end
  status.stop(status.failed, "%s: %dx%d pixels; latlong is twice as wide as high, cube six squares one above the other, "
    .. "angular a square", path, size[1], size[2])
end

--- Coefficients [3][(lmax+1)^2] of an image's first layer, in ylm's convention, and facts of the way there.
local function project(given, path, lmax)
  local ylm = require "ylm"
  local image = status.need_kind("ylm.image", "an image", path, ylm.load(path))
  local layer, size = image:layer(), image.size
  local mapping = mapping_of(given, path, size)
  local finite, where = core.array_finite(layer)
  if not finite then
    local pixel = math.floor((where - 1) / (layer.shape[3] or 1))
    status.stop(status.failed, "%s: pixel (%d, %d) is not finite", path, pixel % size[1] + 1, math.floor(pixel / size[1]) + 1)
  end
  local up = given.up and choice("up", given.up, { "y", "z" }) or "y"
  local c, about = status.need(ylm.sh.project(lmax, image, { mapping = mapping, up = up,
    progress = report.progress(given) }))
  if #c.shape == 1 then c = ylm.stack { c, c, c } end
  if c.shape[1] < 3 then c = ylm.stack { c[1], c[1], c[1] } end
  return c[{ 1, 3 }], { environment = path, width = size[1], height = size[2], mapping = mapping, up = up, error = about.error }
end

--- The least value over the sphere, by Newton's steps from the least of many directions; of any row.
local function least_of(ylm, c)
  c = c:clone()
  core.array_set_convention(c, 0)
  local n = 64
  local directions = status.need(core.sh_rule(n, 2 * n, -1, 1))
  local lmax, worst = ylm.sh.lmax(c.shape[2]), math.huge
  local values = ylm.sh.reconstruct(c, directions)
  for k = 1, c.shape[1] do
    local row, least = values[k], values[k]:min()
    local near = row:less_equal(least + 0.02 * (row:max() - least))
    local at = directions:select(near)
    for _ = 1, 40 do -- down the slope, as far as the curvature lets it
      local _, dY, ddY = ylm.sh.eval(lmax, at, { derivatives = 2 })
      local weights = c[k]:reshape { 1, c.shape[2], 1 }
      local slope = (dY * weights):sum(2)
      local bend = (ddY * weights):sum(2):abs():sum { axis = 2, keep = true } + 1e-300
      at = at - slope / (2 * bend)
      at = at / (at ^ 2):sum({ axis = 2, keep = true }):sqrt()
    end
    worst = math.min(worst, least, ylm.sh.reconstruct(c[k], at):min())
  end
  return worst
end

--- Without ringing: the widest window that leaves nothing below 0, between the directions that sh.dering looks at too.
local function dering(c)
  local ylm = require "ylm"
  local scale, minimum, out, about = math.max(c:abs():max(), 1e-300), 0, nil, nil
  for _ = 1, 6 do
    out, about = status.need(ylm.sh.dering(c, { minimum = minimum, nodes = 64 }))
    local least = about.width and least_of(ylm, out) or least_of(ylm, c)
    if least >= 0 or not about.reached then break end
    minimum = minimum - 1.01 * least + 1e-8 * scale
  end
  local flat = { 1, c.shape[1] * c.shape[2] }
  return out, {
    window = about.width and "hann" or "none", width = about.width, reached = about.reached,
    minimum_before = least_of(ylm, c), minimum = least_of(ylm, out),
    l2 = ylm.sh.relative_error(out:reshape(flat), c:reshape(flat))[1],
  }
end

--- "-0" is written "0".
local function plain_number(x) return ("%.9g"):format(x + 0) end

--- Rows of text for coefficients in the shape of their system, with what stands before each.
local function table_of(c, system, lmax)
  local out = {}
  local function line(label, row)
    local words = {}
    for i, x in ipairs(row) do words[i] = ("%15s"):format(plain_number(x)) end
    out[#out + 1] = ("%-6s %s"):format(label, table.concat(words, " "))
  end
  local t = c:totable()
  if system == "unity" then
    for i, name in ipairs { "SHAr", "SHAg", "SHAb", "SHBr", "SHBg", "SHBb", "SHC" } do line(name, t[i]) end
    return out
  end
  local is_even, is_last, i = system == "mrtrix" or system == "dipy", channels_last[system], 0
  for l = 0, lmax, is_even and 2 or 1 do
    for m = -l, l do
      i = i + 1
      local row = is_last and t[i] or { t[1][i], t[2][i], t[3][i] }
      if system == "scipy" then row = { t[1][i][1], t[1][i][2], t[2][i][1], t[2][i][2], t[3][i][1], t[3][i][2] } end
      line(("%d %d"):format(l, m), row)
    end
  end
  return out
end

--- Rows { r, g, b } in the order of the coefficients, for code.
local function colours_of(c, system)
  local t = c:totable()
  if channels_last[system] then return t end
  local out = {}
  for i = 1, #t[1] do out[i] = { t[1][i], t[2][i], t[3][i] } end
  return out
end

--- Sentences about the result, for the head of text and code.
local function about_of(facts)
  local lines = {
    ("Spherical harmonics of %s (%dx%d, %s, %s up) by ylm sh"):format(facts.environment:match "[^/\\]+$", facts.width,
      facts.height, facts.mapping, facts.up),
    ("convention %s, %s, lmax %d; docs/conventions.md has its formulas"):format(facts.convention, facts.quantity, facts.lmax),
  }
  local d = facts.dering
  if d then
    lines[#lines + 1] = d.width and ("without ringing: hann window of width %.4g, least value %s instead of %s, L2 error %.4g")
      :format(d.width, plain_number(d.minimum), plain_number(d.minimum_before), d.l2)
      or ("without ringing: no window was needed, the least value is %s"):format(plain_number(d.minimum))
  end
  if facts.odd_left_out then
    lines[#lines + 1] = ("odd degrees are left out: %.4g of the L2 norm"):format(facts.odd_left_out)
  end
  return lines
end

--- The share of the L2 norm in odd degrees.
local function odd_share(c, lmax)
  local odd, all = 0, (c ^ 2):sum()
  for l = 1, lmax, 2 do odd = odd + (c[{ {}, { l * l + 1, (l + 1) ^ 2 } }] ^ 2):sum() end
  return all > 0 and math.sqrt(odd / all) or 0
end

local function write(given, text)
  if not given.output then
    io.stdout:write(text)
    return
  end
  status.need(core.file_save(given.output, text))
end

local function run(given)
  local ylm = require "ylm"
  local format = given.json and "json" or choice("format", given.format or "text", formats)
  local convention = convention_of(given)
  local system = convention:match "^%S+"
  local lmax = given.lmax or 2
  if lmax ~= math.floor(lmax) or lmax < 0 or lmax > 64 then
    status.stop(status.usage, "sh: --lmax is a whole number from 0 to 64, got %.14g", lmax)
  end
  if (system == "unity" or system == "three.js" or system == "filament") and lmax ~= 2 then
    status.stop(status.usage, "sh: --as %s holds lmax 2, got --lmax %d", system, lmax)
  end
  if (system == "mrtrix" or system == "dipy") and lmax % 2 == 1 then
    status.stop(status.usage, "sh: --as %s holds even degrees: --lmax %d or %d, got %d", system, lmax - 1, lmax + 1, lmax)
  end
  local is_code = format == "glsl" or format == "c" or format == "lua"
  if is_code and (not sh_code.knows(system) or lmax > 8) then
    status.stop(status.usage, "sh: --format %s is not written for %s: text, json and npy are", format,
      lmax > 8 and "lmax above 8" or "'" .. system .. "', whose numbers are no factors of polynomials")
  end
  if format == "npy" and not given.output then status.stop(status.usage, "sh: --format npy needs -o FILE.npy") end
  if format == "npy" then status.need_output("sh", given.output, "npy") end
  if given.output and format ~= "npy" then status.need(core.file_probe(given.output)) end
  local c, facts = project(given, given[1], lmax)
  local irradiance = is_irradiance[system] or convention:find "irradiance" ~= nil
  if irradiance then c = ylm.sh.convert(c, "ylm irradiance") end
  if given.dering then c, facts.dering = dering(c) end
  facts.convention, facts.lmax = convention, lmax
  facts.quantity = is_irradiance[system] and "irradiance/pi" or irradiance and "irradiance" or "radiance"
  if system == "mrtrix" or system == "dipy" then facts.odd_left_out = odd_share(c, lmax) end
  local result = status.need(ylm.sh.convert(c, convention))
  local about, size = about_of(facts), result:abs()
  local shown = result * size:greater(1e-12 * size:max()) -- rounding is not printed
  if facts.dering and not facts.dering.reached then
    io.stderr:write("ylm: sh: no window leaves every direction above 0: light that is negative on average has ringing that "
      .. "no window removes\n")
  end
  if format == "npy" then
    status.need(result:save(given.output))
  elseif format == "json" then
    facts.coefficients = result:totable()
    write(given, report.json(facts) .. "\n")
  elseif is_code then
    write(given, sh_code[format](colours_of(shown, system), system, lmax, about))
  else
    write(given, "# " .. table.concat(about, "\n# ") .. "\n" .. table.concat(table_of(shown, system, lmax), "\n") .. "\n")
  end
  if (format == "npy" or given.output) and not given.quiet then
    report.say(given, "%s", table.concat(about, "\n"))
  end
end

return {
  summary = "spherical harmonics of an environment map, in the convention of an engine, as text, JSON, code or .npy",
  usage = "ENVIRONMENT [--as NAME] [--lmax 2] [--irradiance] [--dering]    ENVIRONMENT: .hdr, .exr, .png or .pfm",
  least = 1,
  most = 1,
  options = {
    { "as", nil, "NAME", "the convention: ylm (default), plain, three.js, filament, lovr, unity, 3dgs, e3nn, n3d, sn3d, scipy, "
      .. "mrtrix, dipy; with axes: \"plain x,z,-y\"" },
    { "lmax", nil, "N", "the highest degree, default 2" },
    { "irradiance", nil, nil, "of surfaces by their normals, instead of radiance (unity, filament: always, over pi)" },
    { "dering", nil, nil, "no direction below 0, by the widest window that does it; says what it costs" },
    { "up", nil, "AXIS", "the image's pole: y (default; the middle is -z) or z (the middle is +x)" },
    { "mapping", nil, "NAME", "latlong, cube (+x -x +y -y +z -z in a column) or angular; default: by the size" },
    { "format", nil, "NAME", "text (default), json, glsl, c, lua (with a function that evaluates), npy" },
    { "output", "-o", "FILE", "where it is written; default: stdout" },
  },
  notes = "Colours of .png are decoded from sRGB. What a convention's numbers mean, and the sign and the factor of each, is in\n"
    .. "docs/conventions.md; three.js and Gaussian splats want radiance, and shade by the cosine themselves or not at all.",
  examples = { "ylm sh sky.hdr --as three.js", "ylm sh sky.hdr --as filament --dering --format glsl -o sky.glsl",
    "ylm sh cube.exr --mapping cube --lmax 3 --format json" },
  run = run,
}
