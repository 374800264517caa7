-- Refusals of image viewers.

local function case(call, says) return { call = call, says = says } end

--- A function of displays without one: nobody listens here.
local function without(name)
  return function(ylm)
    local method = debug.getregistry and require("ylm.describe").objects.display.methods[name]
    return ylm and method({}, "a", {})
  end
end

return {
  display = {
    case(function(ylm) return ylm.display() end, "'host:port', port 1 to 65535, such as '127.0.0.1:14158' expected, got nil"),
    case(function(ylm) return ylm.display "a:0" end, "port 1 to 65535"),
    case(function(ylm) return ylm.display "a:b:c" end, "'host:port'"),
    case(function(ylm) return ylm.display "127.0.0.1:9" end, "no image viewer listens at 127.0.0.1:9"),
  },
  ["display:send"] = { case(without "send", "a display expected before the colon") },
  ["display:drop"] = { case(without "drop", "a display expected before the colon") },
  ["display:close"] = { case(without "close", "a display expected before the colon") },
}
