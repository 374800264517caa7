-- Refusals of teams.

local function case(call, says) return { call = call, says = says } end

return {
  ["grid_set:save"] = {
    case(function(ylm)
      local save = ylm.bake and require("ylm.c.core").metatable("ylm.grid_set").save
      return save({}, "x.pvtu")
    end, "a grid in bricks expected before the colon, got a table"),
  },
  team = {
    case(function(ylm)
      -- a launcher has started several, and this ylm has no MPI
      local home, loader, environment = require "ylm.team", package.preload["ylm.c.mpi"], os.getenv
      local binding = package.loaded["ylm.c.mpi"]
      package.loaded["ylm.c.mpi"] = nil
      package.preload["ylm.c.mpi"] = function() error("no libmpi.so", 0) end
      os.getenv = function(name) return name == "OMPI_COMM_WORLD_SIZE" and "8" or environment(name) end -- luacheck: ignore 122
      local made = home.forget()
      local ok, message = pcall(function() return ylm.team() end)
      os.getenv = environment -- luacheck: ignore 122
      package.preload["ylm.c.mpi"], package.loaded["ylm.c.mpi"] = loader, binding
      home.forget(made)
      if not ok then error(message, 0) end
    end, "team: started 8 times by mpirun, but ylm was built without MPI: install libopenmpi%-dev"),
  },
  ["team:each"] = {
    case(function(ylm) return ylm.team().each({}, {}, print) end, "each: a team expected before the colon, got a table"),
    case(function(ylm) return ylm.team():each(3, print) end, "#1 to 'each' %(a list of cases expected, got 3"),
    case(function(ylm) return ylm.team():each({ 1 }, 5) end, "#2 to 'each' %(a function%(case, i%) expected, got 5"),
    case(function(ylm) return ylm.team():each({ 1 }, print, { jornal = "x" }) end, "did you mean 'journal'"),
    case(function(ylm) return ylm.team():each({ print }, print, { journal = "x" }) end, "case 1 is a function"),
    case(function(ylm) return ylm.team():each({ 1, 2 }, function(i) return { x = { i, print } } end) end,
      "each: case 1: results are numbers.*the result%.x%[2%] is a function"),
    case(function(ylm) return ylm.team():each({ 1 }, function() return { ylm.sphere_light { at = { 0, 0, 0 } } } end) end,
      "the result%[1%] is an object"),
    case(function(ylm)
      return ylm.team():each({ 1 }, function()
        local t = {}
        t.t = t
        return t
      end)
    end, "does one hold itself"),
    case(function(ylm)
      return ylm.team():each({ 1 }, function() return ylm.team():each({ 1 }, function() return 1 end) end)
    end, "cannot divide work again"),
  },
}
