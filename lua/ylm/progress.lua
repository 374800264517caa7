--- What `progress =` accepts, as a function for C: nil, a function, or true for a bar on standard error.

local progress = {}

--- A function(done, total, stage) that draws a bar and ends it with a newline at done == total.
function progress.bar(file)
  file = file or io.stderr
  local width, last = 40, nil
  return function(done, total, stage)
    local part = total > 0 and done / total or 1
    local text = ("\r%-24s [%s%s] %3d%%"):format(stage or "", ("#"):rep(math.floor(part * width)),
      (" "):rep(width - math.floor(part * width)), math.floor(part * 100))
    if text ~= last then file:write(text) end
    last = text
    if done >= total then
      file:write("\n")
      last = nil
    end
    file:flush()
  end
end

--- The function to hand to C for an option's value.
function progress.of(value)
  if value == true then return progress.bar() end
  return value or nil
end

return progress
