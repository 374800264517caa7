--- ylm: spherical-harmonic lighting. contents.lua is the table of contents.
--
-- Modules load when they are first used, so that SH mathematics alone needs
-- nothing but libylm.so.

local check = require "ylm.check"
local core = require "ylm.c.core"
local describe = require "ylm.describe".describe
local library = require "ylm.library"
local memory = require "ylm.memory"

-- A kernel set or a number of threads that is silently not the one asked for spoils every measurement.
do
  local good, message = core.environment()
  if not good then check.fail("%s", message) end
end

local ylm = { version = (core.info()) }

--- Public name -> a module that is a table of functions itself.
local tables = {
  sh = "ylm.sh",
  vulkan = "ylm.vulkan",
}

--- Functions that modules further down the ladder call, and the modules that define them.
for module, name in pairs { ["ylm.page"] = "save", ["ylm.page.lightmap"] = "save", ["ylm.live"] = "live",
  ["ylm.inverse"] = "inverse_lighting", ["ylm.plot.polar"] = "polar" } do
  library.later[module] = function(...) return require(module)[name](...) end
end

local home = {}
for _, list in ipairs { require "ylm.contents", require "ylm.light.kinds" } do
  for _, entry in ipairs(list) do
    for i = 2, #entry do home[entry[i]] = entry[1] end
  end
end

--- Public names that the module does not hold from the start, and "info" and "names".
local function listed()
  local names = { "info", "names", "version" }
  for name in pairs(home) do names[#names + 1] = name end
  for name in pairs(tables) do names[#names + 1] = name end
  table.sort(names)
  return names
end

setmetatable(ylm, {
  __index = function(t, name)
    local value
    if tables[name] then value = require(tables[name])
    elseif home[name] then value = memory.public(require(home[name])[name])
    else return check.no_name("", name, listed()) end
    rawset(t, name, value)
    return value
  end,
})

describe "names" {
  about = "Every public function, form and table of the module, sorted. A name that is one of them misspelt raises with a guess; "
    .. "other names that ylm lacks are nil. ylm.version is a string.",
  arguments = {},
  returns = { { "names", "table", "a list of strings; some name tables of functions (\"sh\")" } },
  errors = "none",
  example = "assert(#ylm.names() > 0)",
}
function ylm.names()
  local names = {}
  for name in pairs(home) do names[#names + 1] = name end
  for name in pairs(tables) do names[#names + 1] = name end
  table.sort(names)
  return names
end

describe "info" {
  shelf = "everyday",
  about = "Version, kernel sets, threads, libraries: what this ylm is made of. Loads the libraries to know.",
  arguments = {},
  returns = { { "info", "table", "version (also ylm.version), kernel (the set in use; YLM_ISA forces one), kernels (a list), "
    .. "threads, lua, parts (those that load: core, and where installed codec: image files, scene: rays, "
    .. "vtk: pictures, vulkan: computing on a GPU, mpi: work that processes share, rival: methods to compare with)" } },
  errors = "none (require \"ylm\" raises where the environment's YLM_ISA or YLM_THREADS is not what it may be)",
  example = "assert(ylm.info().threads >= 1 and ylm.info().parts[1] == 'core')",
}
function ylm.info()
  local version, kernel, kernels, threads = core.info()
  local parts = { "core" }
  for _, name in ipairs { "codec", "scene", "vtk", "vulkan", "mpi", "rival" } do
    if pcall(require, "ylm.c." .. name) then parts[#parts + 1] = name end
  end
  return { version = version, parts = parts, kernel = kernel, kernels = kernels, threads = threads,
    lua = jit and jit.version or _VERSION }
end

return ylm
