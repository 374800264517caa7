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
