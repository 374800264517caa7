--- Image viewers that show a picture while it is made: tev, and those that speak its protocol.

local check = require "ylm.check"
local core = require "ylm.c.core"
local description = require "ylm.describe"
local describe = description.describe
local form = require "ylm.form"
local library = require "ylm.library"
local memory = require "ylm.memory"
local warning = require "ylm.warning"

local display = {}

local AGAIN = 0.25 -- seconds between two pictures of one rendering
local PORT = 14158 -- where tev listens

local methods = {}
local metatable = { __index = methods, __kind = "display",
  __tostring = function(self) return ("ylm.display of %s%s"):format(self.address, self.handle and "" or ", closed") end }

description.object "display" {
  about = "A connection to an image viewer, from ylm.display.",
  fields = { { "address", "string", "host:port" } },
  methods = methods,
}

local function is_display(x) return type(x) == "table" and getmetatable(x) == metatable end

--- Host and port of "host:port", "host", ":port" or "[::1]:port"; or nil and the sentence that says what is wanted.
local function parts_of(address)
  local host, port = address:match "^%[([%x:.]+)%]:?(%d*)$"
  if not host then host, port = address:match "^([^:%s%c]*):?(%d*)$" end
  if not host or (host == "" and port == "") then return nil end
  if port == "" and address:find ":$" then return nil end
  local number = port == "" and PORT or tonumber(port)
  if #port > 5 or number < 1 or number > 65535 then return nil end
  return host == "" and "127.0.0.1" or host, number
end

function display.is_address(text) return parts_of(text) ~= nil end

local WANTED = "'host:port', port 1 to 65535, such as '127.0.0.1:" .. PORT .. "'"

display.WANTED = WANTED

--- Options that take a viewer: an open one, or where it listens.
function form.types.display(x)
  if is_display(x) and x.handle then return x end
  if type(x) == "string" and parts_of(x) then return x end
  return nil, "a ylm.display that is open, or " .. WANTED
end

display.fields = {
  { "display", "display", optional = true,
    about = "an image viewer (tev) that shows the picture while it is made: ylm.display, or 'host:port'. A viewer that does not "
      .. "listen is a warning" },
  { "display_name", "string", optional = true, about = "of the picture there; default: the scene's, and how it is made" },
}

-- Connections ----------------------------------------------------------------------------

describe "display" {
  about = "Connects to an image viewer that speaks the protocol of tev. The option `display` of scene:render and "
    .. "scene:pathtrace takes it, and it shows pictures of one's own.",
  arguments = { { "address", "string", "'host:port'; without a port " .. PORT } },
  returns = { { "display", "display", "or nil, message, 'EIO' where nobody listens, 'EMISSING', 'ENOMEM'" } },
  errors = "raises on what is no address",
  example = [[
local viewer, message, code = ylm.display "127.0.0.1:9"        -- nobody listens there
assert(viewer == nil and code == "EIO" and message == "no image viewer listens at 127.0.0.1:9")]],
}
function display.display(address)
  local host, port
  if type(address) == "string" then host, port = parts_of(address) end
  if not host then return check.bad(1, "display", "%s expected, got %s", WANTED, check.describe(address)) end
  local codec, message, code = library.open("codec",
    "image viewers need libylm_codec: install libopenexr-dev and libpng-dev and run make again (%s)")
  if not codec then return nil, message, code end
  local handle
  handle, message, code = codec.display_open(host, port)
  if not handle then return nil, message, code end
  return setmetatable({ handle = handle, codec = codec, address = ("%s:%d"):format(host, port) }, metatable)
end

local example = [[
local viewer = ylm.display "127.0.0.1:9"
if viewer then assert(viewer:%s) end                            -- where a viewer listens]]

local function open_one(self, name)
  if not is_display(self) then
    return check.fail("%s: a display expected before the colon, got %s", name, check.describe(self))
  end
  if not self.handle then return check.bad(1, name, "the display has been closed") end
  return self
end

-- Pictures -------------------------------------------------------------------------------

local names_of = {
  radiance = { "R", "G", "B" },
  normal = { "normal.X", "normal.Y", "normal.Z" },
  position = { "position.X", "position.Y", "position.Z" },
}
local letters = { "R", "G", "B", "A" }

--- A layer as the binding takes it: its numbers, and the names of its channels as in .exr files.
local function layer_of(image, name, channels, first)
  local layer = { image:layer(name) }
  local known = names_of[name] or (first and channels == 3 and names_of.radiance)
  for c = 1, channels do
    layer[c + 1] = known and known[c] or first and channels == 1 and "Y" or channels == 1 and name
      or name .. "." .. letters[c]
  end
  return layer
end

--- The layers of an image, `most` at most.
local function layers_of(image, most)
  local list, channels = image:layers()
  local out = {}
  for i = 1, math.min(most, #list) do out[i] = layer_of(image, list[i], channels[list[i]], i == 1) end
  return out
end

describe "display:send" {
  about = "Sends a picture: what differs from what was sent under its name before.",
  arguments = { { "name", "string", "of the picture in the viewer, 1 to 255 bytes without control characters" },
    { "image", "image", "its layers, 32 at most, named as in .exr files" } },
  returns = { { "ok", "boolean", "true; or nil, message, 'EIO' where the viewer has gone or takes nothing for two seconds" } },
  errors = "raises on a bad name and what is no image",
  example = example:format 'send("a", ylm.image { size = { 8, 8 } })',
}
function methods.send(self, name, image)
  open_one(self, "send")
  if type(name) ~= "string" then return check.bad(1, "send", "a name expected, got %s", check.describe(name)) end
  if core.type(image) ~= "ylm.image" then return check.bad(2, "send", "an image expected, got %s", check.describe(image)) end
  return check.result("send", self.codec.display_send(self.handle, name, layers_of(image, self.codec.display_layers)))
end

describe "display:drop" {
  about = "The viewer forgets the picture of that name.",
  arguments = { { "name", "string", "" } },
  returns = { { "ok", "boolean", "true; or nil, message, 'EIO'" } },
  errors = "raises on a bad name",
  example = example:format 'drop "a"',
}
function methods.drop(self, name)
  open_one(self, "drop")
  if type(name) ~= "string" then return check.bad(1, "drop", "a name expected, got %s", check.describe(name)) end
  return check.result("drop", self.codec.display_drop(self.handle, name))
end

describe "display:close" {
  about = "Ends the connection; the viewer keeps its pictures.",
  arguments = {},
  returns = {},
  errors = "raises on what is no display",
  example = [[
local viewer = ylm.display "127.0.0.1:9"
if viewer then viewer:close() end]],
}
function methods.close(self)
  if not is_display(self) then
    return check.fail("close: a display expected before the colon, got %s", check.describe(self))
  end
  if self.handle then self.codec.display_close(self.handle) end
  self.handle = nil
end

-- While pictures are made --------------------------------------------------------------------

--- A rendering's way to a viewer: { send(layers), progress }. `s` is the scene, `how` the method. A viewer that fails
-- is a warning, once a scene, and forgotten.
function display.begin(s, o, how)
  if not o.display then return nil end
  local viewer, message = o.display, nil
  if type(viewer) == "string" then viewer, message = display.display(viewer) end
  local live = { last = -math.huge, own = viewer ~= o.display, warnings = {} }
  local name = o.display_name or ("%s (%s)"):format(s.name or "scene", how):gsub("%c", " ")
  local function failed(text)
    live.warnings[1] = warning.say(s, "display", "%s: the picture is made without it", text)
    if live.own and viewer then viewer:close() end
    viewer = nil
  end
  if not viewer then failed(message) end
  --- Sends layers as layers_of makes them.
  function live.send(layers)
    if not viewer then return end
    local ok, why = viewer.codec.display_send(viewer.handle, name:sub(1, viewer.codec.display_name), layers)
    if not ok then failed(why) end
  end
  --- Sends picture() now.
  function live.now(picture)
    if not viewer then return end
    live.send((picture()))
    live.last = core.seconds()
  end
  --- Wraps `bar`, or nothing: four times a second picture() makes what is sent; it returns layers or nil.
  function live.progress(bar, picture)
    return function(done, total, stage)
      local now = core.seconds()
      if viewer and now - live.last >= AGAIN then
        local layers = picture()
        if layers then live.send(layers) end
        live.last = core.seconds()
      end
      return not bar or bar(done, total, stage)
    end
  end
  --- Sends the finished image, and adds to the report's warnings.
  function live.finish(image, report)
    if viewer then live.send(layers_of(image, viewer.codec.display_layers)) end
    for _, sentence in ipairs(live.warnings) do
      report.warnings = report.warnings or {}
      report.warnings[#report.warnings + 1] = sentence
    end
    if live.own and viewer then viewer:close() end
  end
  return live
end

--- A rendering's way to who watches it without a viewer: watch.now(image, report) is called as a viewer's `now` is. Its progress
-- may break off the work behind the last ray, too.
function display.watch(watch)
  return { interrupts = true, progress = function(bar) return bar end, finish = function() end,
    now = function(picture, report)
      local _, image = picture()
      watch.now(image, report)
    end }
end

display.layer_of = layer_of

memory.publish(methods)

return display
