-- Refusals of ylm.load and array:save.

local function case(call, says) return { call = call, says = says } end

return {
  load = {
    case(function(ylm) ylm.load() end, "bad argument #1 to 'load' %(a file name expected, got nil%)"),
    case(function(ylm) ylm.load "" end, "a file name expected"),
    case(function(ylm) ylm.load "a\0b" end, "a file name expected"),
    case(function(ylm) ylm.load {} end, "a file name expected"),
    case(function(ylm) ylm.load("x", { row = true }) end, "no field 'row' %(did you mean 'raw'%?%)"),
    case(function(ylm) ylm.load("x", { raw = 1 }) end, "raw must be true or false"),
    case(function(ylm) ylm.load("x", 3) end, "a table of options expected, got 3"),
    case(function(ylm) ylm.load("x", { memry = 1 }) end, "no field 'memry' %(did you mean 'memory'"),
    case(function(ylm) ylm.load("x", { memory = 0 / 0 }) end, "memory must be a number"),
    case(function(ylm) ylm.load("x", { instructions = -1 }) end, "instructions must be a number >= 1"),
    case(function(ylm) ylm.load("x.glb", { light_scale = -1 }) end, "light_scale must be a number >= 0"),
    case(function(ylm) ylm.load("examples/scenes/room.lua", { raw = true }) end,
      "raw is for images, not for scene files: leave it out"),
    case(function(ylm) return ylm.load "no such file.lua" end, "no such file.lua"),
    case(function(ylm) return ylm.load "README.md" end, "README.md: not a file that ylm knows"),
    case(function(ylm) return ylm.load "/nonexistent" end, "No such file"),
    case(function(ylm) return ylm.load "/dev/null" end, "not a regular file"),
    case(function(ylm) return ylm.load "/" end, "/: not a regular file but a folder"),
  },
  ["array:save"] = {
    case(function(ylm) ylm.zeros { 2 }:save() end, "a file name that ends in .npy expected, got nil"),
    case(function(ylm) ylm.zeros { 2 }:save "x.txt" end, "a file name that ends in .npy expected"),
    case(function(ylm) return ylm.zeros { 2 }:save "/nonexistent/x.npy" end, "No such file"),
    case(function(ylm) ylm.zeros { 2 }.save(5, "x.npy") end, "an array expected before the colon, got 5"),
    case(function(ylm)
      local a = ylm.zeros { 2 }
      a:close()
      a:save "x.npy"
    end, "closed"),
  },
}
