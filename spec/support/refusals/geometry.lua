-- Refusals of shapes, meshes and their methods.

local nan, inf = 0 / 0, math.huge

local function case(call, says) return { call = call, says = says } end

--- Refusals of every shape, given the fields that make a good one.
local function shape(name, good, own)
  local function with(field, value)
    return function(ylm)
      local fields = {}
      for k, v in pairs(good) do fields[k] = v end
      fields[field] = value
      local result, message = ylm[name](fields) -- no tail call, which would hide the line
      return result, message
    end
  end
  local all = {
    case(function(ylm) ylm[name]() end, name .. ": a table of named fields expected, got nil"),
    case(function(ylm) ylm[name](5) end, name .. ": a table of named fields expected, got 5"),
    case(with("materiel", 1), name .. ": no field 'materiel' %(did you mean 'material'%?%)"),
    case(with("at", { 1, 2 }), "at must be three numbers"),
    case(with("at", { nan, 0, 0 }), "at must be three numbers"),
    case(with("at", { 1e300, 0, 0 }), "moves vertex 1 to infinity"),
    case(with("scale", 0), "scale must be a number or {x, y, z}, none of them zero"),
    case(with("scale", inf), "scale must be"),
    case(with("scale", { 1, 0, 1 }), "scale must be"),
    case(with("rotate", { axis = { 0, 0, 0 }, angle = 1 }), "rotate must be { axis"),
    case(with("rotate", { axis = { 0, 0, 1 }, angel = 1 }), "rotate must be { axis"),
    case(with("rotate", 90), "rotate must be { axis"),
    case(with("matrix", { 1, 2, 3 }), "matrix must be three rows"),
    case(with("matrix", { { 1, 0, 0, 0 }, { 0, 1, 0, 0 }, { 0, 0, 0, 0 } }), "the transform is singular"),
    case(with("occludes", 1), "occludes must be true or false, got 1"),
    case(function(ylm)
      local fields = { at = { 0, 0, 0 }, matrix = { { 1, 0, 0, 0 }, { 0, 1, 0, 0 }, { 0, 0, 1, 0 } } }
      for k, v in pairs(good) do fields[k] = v end
      ylm[name](fields)
    end, "matrix stands instead of at"),
  }
  for _, c in ipairs(own(with)) do all[#all + 1] = c end
  return all
end

local triangle = { vertices = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, triangles = { { 1, 2, 3 } } }

--- A method on something else, and its own cases.
local function method(name, own)
  local all = {
    case(function(ylm) ylm.box {}.mesh[name](5) end, name .. ": a mesh expected before the colon, got 5"),
    case(function(ylm) ylm.box {}.mesh[name](ylm.zeros { 2 }) end, name .. ": a mesh expected"),
  }
  for _, c in ipairs(own or {}) do all[#all + 1] = c end
  return all
end

return {
  quad = shape("quad", { corner = { 0, 0, 0 }, u = { 1, 0, 0 }, v = { 0, 1, 0 } }, function(with)
    return {
      case(function(ylm) ylm.quad {} end, "field 'corner' is missing"),
      case(with("u", { 0, 0, 0 }), "u must be three numbers .* not all zero"),
      case(with("v", { 2, 0, 0 }), "u and v are parallel"),
      case(with("v", { 0, nan, 0 }), "v must be three numbers"),
      case(with("divide", 0), "divide must be an integer >= 1, or two of them"),
      case(with("divide", { 2, -1 }), "divide must be"),
      case(with("divide", 1e9), "at most 1048576 divisions"),
      case(with("divide", 1048576), "too large"),
      case(with("corner", { 1e300, 0, 0 }), "not finite"),
    }
  end),
  sphere = shape("sphere", {}, function(with)
    return {
      case(with("radius", 0), "radius must be a number > 0"), case(with("radius", -1), "radius must be a number > 0"),
      case(with("radius", nan), "radius must be a number > 0"), case(with("radius", 1e300), "radius must be > 0"),
      case(with("divide", 2), "3 segments and 2 rings at least"), case(with("divide", nan), "divide must be"),
    }
  end),
  box = shape("box", {}, function(with)
    return {
      case(with("bounds", { { 0, 0, 0 }, { 1, 1, 0 } }), "bounds must be"),
      case(with("bounds", { { 0, 0, 0 }, { 1, 1, inf } }), "bounds must be"),
      case(with("divide", 0), "divide must be an integer >= 1"), case(with("divide", 1.5), "divide must be"),
    }
  end),
  torus = shape("torus", {}, function(with)
    return {
      case(with("radius", -1), "radius must be a number > 0"), case(with("tube", 0), "tube must be a number > 0"),
      case(with("tube", inf), "tube must be"), case(with("divide", 2), "3 segments each way"),
    }
  end),
  knot = shape("knot", {}, function(with)
    return {
      case(with("p", 0), "p must be an integer >= 1 and <= 64"), case(with("q", 1e6), "q must be an integer"),
      case(with("p", 6), "common divisor"), case(with("tube", -1), "tube must be a number > 0"),
      case(with("minor", 1), "minor must be less than radius"), case(with("divide", { 1048576, 1048576 }), "too large"),
    }
  end),
  mesh = shape("mesh", triangle, function(with)
    return {
      case(function(ylm) ylm.mesh {} end, "field 'file' is missing"),
      case(function(ylm) return ylm.mesh { file = "/nonexistent/x.obj" } end, "/nonexistent/x.obj: No such file"),
      case(function(ylm) return ylm.mesh { file = "/" } end, "not a regular file"),
      case(function(ylm) ylm.mesh { file = "" } end, "file must be a file name"),
      case(function(ylm) ylm.mesh { file = "a\0b" } end, "file must be a file name"),
      case(with("file", "x.obj"), "not both"),
      case(with("triangles", { { 1, 2, 4 } }), "triangle 1: index 4 is not an integer from 1 to 3"),
      case(with("triangles", { { 1, 2, 1.5 } }), "index 1.5"), case(with("triangles", { { 1, 2, nan } }), "triangle 1"),
      case(with("triangles", { { 1, 2 } }), "rows of 3 numbers expected"),
      case(with("vertices", { { 0, 0, inf } }), "row 1 is not finite"), case(with("vertices", "x"), "got 'x'"),
      case(with("normals", { { 0, 0, 1 } }), "do not fit"), case(with("uvs", { { 0, 0 } }), "do not fit"),
      case(with("colours", { { 0, 0, 0 } }), "do not fit"),
      case(with("normals", { { 0, 0, 1 }, { 0, 0, nan }, { 0, 0, 1 } }), "a normal is not finite"),
    }
  end),
  ["mesh:vertices"] = method "vertices",
  ["mesh:normals"] = method "normals",
  ["mesh:uvs"] = method "uvs",
  ["mesh:colours"] = method "colours",
  ["mesh:triangles"] = method "triangles",
  ["mesh:save"] = method("save", {
    case(function(ylm) ylm.box {}.mesh:save() end, "a file name that ends in .ply expected, got nil"),
    case(function(ylm) ylm.box {}.mesh:save "x.obj" end, "a file name that ends in .ply expected"),
    case(function(ylm) return ylm.box {}.mesh:save "/nonexistent/x.ply" end, "No such file"),
  }),
  ["mesh:unwrap"] = method("unwrap", {
    case(function(ylm) ylm.box {}.mesh:unwrap(7) end, "a table of options expected, got 7"),
    case(function(ylm) ylm.box {}.mesh:unwrap { texels = 15 } end, "texels must be"),
    case(function(ylm) ylm.box {}.mesh:unwrap { texel = 100 } end, "did you mean 'texels'"),
    case(function(ylm) ylm.box {}.mesh:unwrap { density = 0 } end, "density must be"),
    case(function(ylm) ylm.box {}.mesh:unwrap { gutter = 65 } end, "gutter must be"),
    case(function(ylm) ylm.box {}.mesh:unwrap { angle = 90 } end, "angle must be"),
    case(function(ylm) ylm.box {}.mesh:unwrap { stretch = 1 } end, "stretch must be"),
    case(function(ylm) return ylm.box {}.mesh:unwrap { texels = 16 } end, "6 charts with gutters of 1 do not fit into 16 texels"),
    case(function(ylm) return ylm.box {}.mesh:unwrap { density = 1e6 } end, "more than 16384 texels along a side"),
    case(function(ylm) ylm.mesh { vertices = {}, triangles = {} }.mesh:unwrap() end, "there is no triangle"),
    case(function(ylm) ylm.mesh { vertices = { { 1, 1, 1 } }, triangles = { { 1, 1, 1 } } }.mesh:unwrap() end,
      "none of the 1 triangles has an area"),
  }),
}
