-- Files for ParaView, as VTK's own readers find them.

local core = require "ylm.c.core"
local scratch = require "spec.support.scratch"
local views = require "spec.support.views"
local ylm = require "ylm"

local vtk = views.vtk "files for ParaView"
if not vtk then return end

local uniform = views.uniform

describe("grid:save \"grid.vtu\"", function()
  local folder
  before_each(function() folder = scratch.new() end)
  after_each(function() folder:remove() end)

  it("is what VTK's own reader finds", function()
    local g, path = uniform(), folder.path .. "/grid.vtu"
    assert(g:save(path))
    local text = assert(vtk.describe(path))
    assert.truthy(text:find("vtkUnstructuredGrid 125 64\nbounds -1 -1 -1 1 1 1\ntype 12\n", 1, true), text)
    for _, line in ipairs { "point irradiance +x 3 125", "point irradiance -z 3 125",
      "point L00 1 125", "point gradient L00 3 125", "point lambda 1 125", "point norm 1 125",
      "point state 1 125", "cell level 1 64", "cell error 1 64", "cell occupied 1 64" } do
      assert.truthy(text:find("\n" .. line .. " ", 1, true), line .. " is missing in\n" .. text)
    end
    local least, largest = text:match "point norm 1 125 (%S+) (%S+)"
    local lo, hi = core.figure_range(core.array_convert(g:points().norm, "double"))
    assert(math.abs(least - lo) < 1e-6 * hi and math.abs(largest - hi) < 1e-6 * hi)
  end)

  it("has the irradiance of surfaces by six normals, and where asked for all coefficients", function()
    local g, path = uniform(), folder.path .. "/grid.vtu"
    assert(g:save(path))
    assert.is_nil(folder:read "grid.vtu":find('Name="coefficients"', 1, true))
    assert(g:save(path, { coefficients = true }))
    assert.truthy(assert(vtk.describe(path)):find(("\npoint coefficients %d 125 "):format(3 * (g.lmax + 1) ^ 2)))
    local bytes, value = folder:read "grid.vtu", g:points().value
    --- The bytes of an array of the file.
    local function content(name, size)
      local offset = tonumber(bytes:match('Name="' .. name:gsub("%p", "%%%0") .. '" NumberOfComponents="%d+" format="appended" '
        .. 'offset="(%d+)"'))
      local first = bytes:find("_", bytes:find("<AppendedData encoding=\"raw\">\n", 1, true), true) + 9 + offset
      return bytes:sub(first, first + size - 1)
    end
    assert.is_true(content("coefficients", #value:bytes()) == value:bytes())
    for name, normal in pairs { ["+x"] = { 1, 0, 0 }, ["-y"] = { 0, -1, 0 }, ["+z"] = { 0, 0, 1 } } do
      local E = ylm.array(ylm.sh.irradiance(value, normal), "float")
      assert.is_true(content("irradiance " .. name, #E:bytes()) == E:bytes(), name)
    end
    assert.error_matches(function() g:save(path, { coeficients = true }) end, "did you mean 'coefficients'", 1, true)
  end)

  it("says which points were evaluated, interpolated and in lights, and which cells are occupied", function()
    local quad = ylm.quad { corner = { -0.9, 0.03, 0.9 }, u = { 1.8, 0, 0 }, v = { 0, 0, -1.8 } }
    local g, path = assert(ylm.bake(ylm.adaptive_grid { bounds = views.box, lmax = 1, depth = 5, tolerance = 0.02 },
      ylm.sphere_light { at = { 0.3, 0.1, 0.4 }, radius = 0.2 }, { geometry = quad })), folder.path .. "/grid.vtu"
    assert(g.stats.interpolated > 0 and g.stats.invalid > 0)
    assert(g:save(path))
    local text = assert(vtk.describe(path))
    assert.truthy(text:find "\npoint state 1 %d+ 0 2\n", text)
    assert.truthy(text:find "\ncell occupied 1 %d+ [01] 1\n", text)
    local bytes = folder:read "grid.vtu"
    local offset = tonumber(bytes:match 'Name="state" NumberOfComponents="1" format="appended" offset="(%d+)"')
    local first = bytes:find("_", bytes:find("<AppendedData encoding=\"raw\">\n", 1, true), true) + 1 + offset
    local of = { ["\0\0\0\0"] = 0, ["\0\0\128\63"] = 1, ["\0\0\0\64"] = 2 }
    local count, n = { [0] = 0, 0, 0 }, g.stats.points + g.stats.interpolated
    for i = 0, n - 1 do
      local state = of[bytes:sub(first + 8 + 4 * i, first + 11 + 4 * i)]
      count[state] = count[state] + 1
    end
    assert.equal(g.stats.interpolated, count[1])
    assert.equal(g.stats.invalid, count[2])
  end)

  it("leaves an existing file alone where it cannot be written", function()
    local path = folder:write("grid.vtu", "old")
    assert(scratch.shell("chmod 500 " .. scratch.quote(folder.path)))
    local ok, message, code = uniform():save(folder.path .. "/sub/grid.vtu")
    assert.is_nil(ok)
    assert.equal("EIO", code)
    assert(message)
    scratch.shell("chmod 700 " .. scratch.quote(folder.path))
    assert.equal("old", folder:read "grid.vtu", path)
  end)

  it("has as many pieces as were said, with the same arrays, or is not there", function()
    local function doubles(t) return ylm.array(t, "double") end
    local points, corners = {}, { 1, 2, 3, 4, 5, 6, 7, 8 }
    for i = 0, 7 do points[i + 1] = { i % 2, math.floor(i / 2) % 2, math.floor(i / 4) } end
    local path = folder.path .. "/pieces.vtu"
    local function add(pieces, name, corner)
      return core.figure_pieces_add(pieces, doubles(points), doubles { corner or corners }, { { name, doubles(corners) } }, {})
    end
    local pieces = assert(core.figure_pieces(path, 2))
    assert(add(pieces, "x"))
    assert.same({ nil, "the file was begun for 2 pieces and has 1", "EINVAL" }, { core.figure_pieces_end(pieces) })
    assert.has_error(function() add(pieces, "x") end)
    pieces = assert(core.figure_pieces(path, 2))
    assert(add(pieces, "x"))
    assert.same({ nil, "piece 2 has other arrays than the first", "EINVAL" }, { add(pieces, ("x"):rep(200)) })
    assert.same({ nil, "the file could not be written before", "EIO" }, { core.figure_pieces_end(pieces) })
    assert.same({}, scratch.lines("ls -A " .. scratch.quote(folder.path)))
    pieces = assert(core.figure_pieces(path, 2))
    assert.equal("ERANGE", select(3, add(pieces, "x", { 1, 2, 3, 4, 5, 6, 7, 9 })))
    assert(add(pieces, "x") and add(pieces, "x") and core.figure_pieces_end(pieces))
    assert.truthy(assert(vtk.describe(path)):find("vtkUnstructuredGrid 16 2\nbounds 0 0 0 1 1 1\n", 1, true))
  end)

  it("is refused by VTK where it is cut off, as our message", function()
    local path = folder.path .. "/grid.vtu"
    assert(uniform():save(path))
    local bytes = folder:read "grid.vtu"
    folder:write("grid.vtu", bytes:sub(1, #bytes - 3000))
    local text, message = vtk.describe(path)
    assert(text == nil and message:find("VTK", 1, true), tostring(message))
  end)
end)

describe("shapes and volumes as files", function()
  it("are what VTK's own reader finds", function()
    local folder = scratch.new()
    local shape = core.shape(3)
    core.shape_spheres(shape, ylm.array { { 1, 2, 3 } }, ylm.array { 0.5 }, ylm.array { { 1, 0, 0 } }, 3)
    assert(core.shape_save(shape, folder.path .. "/ball.vtp"))
    local text = assert(vtk.describe(folder.path .. "/ball.vtp"))
    assert.truthy(text:find("vtkPolyData 258 512\nbounds 0.5 1.5 2.5 1.5 2.5 3.5\n", 1, true), text)
    local volume = assert(core.volume({ 0, 0, 0, 2, 1, 1 }, { 4, 2, 2 }, 1))
    core.volume_set(volume, ylm.zeros { 2, 2, 4 })
    assert(core.volume_save(volume, folder.path .. "/v.vti", "a < \"b\""))
    text = assert(vtk.describe(folder.path .. "/v.vti"))
    assert.truthy(text:find("vtkImageData 16 ", 1, true), text)
    assert.truthy(text:find("point a < \"b\" 1 16 0 0", 1, true), text)
    folder:remove()
  end)
end)

describe("view:save \"x.gltf\"", function()
  local folder
  before_each(function() folder = scratch.new() end)
  after_each(function() folder:remove() end)

  local values = {}
  for k = 1, 6 do
    values[k] = {}
    for j = 1, 6 do
      values[k][j] = {}
      for i = 1, 6 do values[k][j][i] = i == 1 and 0 / 0 or (i - 3) ^ 2 + (j - 3) ^ 2 + k end
    end
  end

  it("holds triangles, lines and slices, and the camera; clouds are left out with a sentence", function()
    local camera = ylm.camera { from = { 3, 2, 4 }, at = { 0.1, 0.2, 0 }, fov = 40 }
    local view = ylm.view { volume = { values = values, bounds = views.box }, isosurfaces = { 4, 7 }, slices = true,
      lights = ylm.sphere_light { at = { 2, 0, 0 }, radius = 0.5 }, camera = camera }
    local path = folder.path .. "/v.gltf"
    local said = {}
    local before = ylm.on_warning(function(line) said[#said + 1] = line end)
    local ok, notes = view:save(path)
    ylm.on_warning(before)
    assert(ok, notes)
    assert.equal(1, #said)
    assert.matches("v.gltf lacks the cloud of the picture", said[1], 1, true)
    assert.same({ "clouds have no surface, left out: 1" }, notes)
    local text = assert(vtk.describe(path))
    local least, largest = text:match "bounds (%S+) %S+ %S+ (%S+)"
    assert.near(-1, tonumber(least), 0.3)
    assert.near(2.5, tonumber(largest), 1e-3)
    local model, message, code = ylm.load(path)
    if code == "EMISSING" then return end
    assert(model, message)
    for a = 1, 3 do assert.near(camera.from[a], model.camera.from[a], 1e-12) end
    assert.near(40, model.camera.fov, 1e-6)
    assert.equal(4, #model.geometry)
    local slice = model.geometry[1] -- its picture is part of the file
    assert.truthy(require "ylm.material.texture".of(slice.material))
    for _, piece in ipairs(model.geometry) do assert.equal("both", piece.sides) end
    assert(ylm.view { sh = { { 1, 0, 0, 0 } } }:save(path))
    local lobe = assert(ylm.load(path)).geometry[1].mesh
    local p, n = lobe:vertices():totable()[1], lobe:normals():totable()[1]
    local length = math.sqrt(p[1] ^ 2 + p[2] ^ 2 + p[3] ^ 2)
    for a = 1, 3 do assert.near(p[a] / length, n[a], 1e-2) end -- a ball
  end)

  it("leaves an existing file alone where it cannot be written", function()
    local ok, _, code = ylm.view { sh = { { 1, 0, 0, 0 } } }:save(folder.path .. "/none/v.gltf")
    assert.is_nil(ok)
    assert.equal("EIO", code)
    assert.has_error(function() ylm.view { sh = { { 1, 0, 0, 0 } } }:save "v.glb" end)
  end)
end)
