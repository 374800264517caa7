--- Headless Chromium, driven over its pipe: pages are opened without a network, what they say is kept.
--
--     local browser = assert(browser.open { size = { 320, 180 } })
--     browser:visit("/tmp/x.html", "mode=error")
--     browser:wait "ready"
--     browser:screenshot "/tmp/x.png"
--     browser:close()
--
-- SPEC: pending(browser.missing()) where there is no Chromium.

local json = require "spec.support.json"
local scratch = require "spec.support.scratch"

local browser = {}
browser.__index = browser

local LIMIT = require "spec.support.patience" (120) -- seconds that a browser lives at most

--- Switches of a Chromium that draws by SwiftShader; a newer one that refuses --use-angle=swiftshader wants --use-gl=angle too.
local SWITCHES = "--headless=new --use-angle=swiftshader --enable-unsafe-swiftshader --hide-scrollbars "
  .. "--force-device-scale-factor=1 --no-first-run --no-default-browser-check --disable-extensions --disable-sync "
  .. "--disable-background-networking --disable-component-update --mute-audio"

local names = { "chromium", "chromium-browser", "google-chrome" }

--- Why no browser can be opened; nil where one can.
function browser.missing()
  for _, name in ipairs(names) do
    if scratch.shell("command -v " .. name .. " >/dev/null") then return nil end
  end
  return "chromium is not installed"
end

local function program()
  for _, name in ipairs(names) do
    if scratch.shell("command -v " .. name .. " >/dev/null") then return name end
  end
end

--- A browser with a window of that size; switches: others than those that draw.
function browser.open(o)
  local folder = scratch.new()
  local q = scratch.quote
  assert(scratch.shell(("mkfifo %s %s"):format(q(folder.path .. "/to"), q(folder.path .. "/from"))))
  local root = scratch.shell '[ "$(id -u)" = 0 ]' and "--no-sandbox " or ""
  local switches = o.switches or SWITCHES
  -- A process in between takes what is said to a browser that has gone, so that reading finds it out; writing would end this one.
  assert(scratch.shell(("cd %s && (cat to | HOME=%s env -u LD_PRELOAD timeout -k 5 %d %s %s %s --user-data-dir=%s "
    .. "--remote-debugging-pipe --window-size=%d,%d about:blank 3<&0 4>from </dev/null >log 2>&1 &)"):format(q(folder.path),
    q(folder.path), o.limit or LIMIT, program(), switches, root, q(folder.path .. "/profile"), math.max(500, o.size[1]),
    math.max(400, o.size[2]))))
  local self = setmetatable({ folder = folder, number = 0, said = {} }, browser)
  self.to = assert(io.open(folder.path .. "/to", "wb"))
  self.from = assert(io.open(folder.path .. "/from", "rb"))
  local target = self:call("Target.createTarget", { url = "about:blank" }).targetId
  self.session = self:call("Target.attachToTarget", { targetId = target, flatten = true }).sessionId
  for _, domain in ipairs { "Page", "Runtime", "Log", "Network" } do self:call(domain .. ".enable") end
  self:call("Network.emulateNetworkConditions", { offline = true, latency = 0, downloadThroughput = -1,
    uploadThroughput = -1 })
  self:call("Emulation.setDeviceMetricsOverride", { width = o.size[1], height = o.size[2], deviceScaleFactor = 1,
    mobile = false })
  return self
end

--- The next message of the browser.
function browser:read()
  local out = {}
  while true do
    local c = self.from:read(1)
    if not c then
      self.gone = true
      error("the browser has gone: " .. scratch.text(self.folder.path .. "/log"):sub(-600), 0)
    end
    if c == "\0" then return json.read(table.concat(out)) end
    out[#out + 1] = c
  end
end

--- Keeps what a page says on its console, exceptions, and requests that leave the file.
function browser:hear(message)
  local p = message.params or {}
  if message.method == "Page.loadEventFired" then self.loaded = true end
  if message.method == "Runtime.consoleAPICalled" then
    local words = {}
    for _, x in ipairs(p.args) do words[#words + 1] = tostring(x.value or x.description) end
    self.said[#self.said + 1] = p.type .. ": " .. table.concat(words, " ")
  elseif message.method == "Runtime.exceptionThrown" then
    local d = p.exceptionDetails
    self.said[#self.said + 1] = "exception: " .. tostring(d.exception and d.exception.description or d.text)
  elseif message.method == "Log.entryAdded" and (p.entry.level == "error" or p.entry.level == "warning") then
    self.said[#self.said + 1] = p.entry.level .. ": " .. p.entry.text
  elseif message.method == "Network.requestWillBeSent" and not p.request.url:find "^file:"
    and not p.request.url:find "^data:" then
    self.said[#self.said + 1] = "request: " .. p.request.url
  elseif message.method == "Page.javascriptDialogOpening" then
    self.said[#self.said + 1] = "dialog: " .. p.message
    self:call("Page.handleJavaScriptDialog", { accept = true })
  end
end

--- A command of the protocol; returns its result.
function browser:call(method, params)
  if self.gone then error("the browser has gone", 0) end -- a pipe that nobody reads ends this process
  self.number = self.number + 1
  local number = self.number
  local head = ('{"id":%d,"method":"%s"'):format(number, method)
  if self.session then head = head .. ',"sessionId":' .. json.write(self.session) end
  self.to:write(head, ',"params":', params and json.write(params) or "{}", "}\0")
  self.to:flush()
  while true do
    local message = self:read()
    if message.id == number then
      if message.error then error(method .. ": " .. tostring(message.error.message), 0) end
      return message.result
    end
    self:hear(message)
  end
end

--- The value of an expression of JavaScript.
function browser:eval(text)
  local r = self:call("Runtime.evaluate", { expression = text, returnByValue = true, awaitPromise = true })
  if r.exceptionDetails then error("eval: " .. tostring(r.exceptionDetails.exception.description), 0) end
  return r.result.value
end

--- Opens a file, with what stands behind # of its address.
function browser:visit(path, hash)
  for _, url in ipairs { "about:blank", "file://" .. path .. (hash and "#" .. hash or "") } do
    self.loaded = false
    self:call("Page.navigate", { url = url })
    while not self.loaded do self:hear(self:read()) end
  end
end

--- Changes what stands behind # of the address, which the page obeys.
function browser:go(hash)
  self:eval("document.documentElement.dataset.state = 'asked'; location.hash = " .. json.write(hash))
end

--- Waits until the page's state is `state` ("ready", "failed"); its other end is an error. Returns the seconds that it took.
function browser:wait(state)
  local text = ([[new Promise(done => { const began = performance.now(), look = () => {
    const s = document.documentElement.dataset.state;
    if (s === 'ready' || s === 'failed') done(s + ' ' + (performance.now() - began) / 1000); else setTimeout(look, 20); };
    look(); })]])
  local is, seconds = self:eval(text):match "^(%a+) (.*)$"
  if is ~= state then
    error(("the page is %s: %s"):format(is, tostring(self:eval "document.documentElement.dataset.why")), 0)
  end
  return tonumber(seconds)
end

local digits = {}
for i = 0, 63 do
  digits[("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"):byte(i + 1)] = i
end

--- Bytes of base64.
function browser.decoded(text)
  local out = {}
  for i = 1, #text, 4 do
    local a, b, c, d = text:byte(i, i + 3)
    local x = digits[a] * 262144 + digits[b] * 4096 + (digits[c] or 0) * 64 + (digits[d] or 0)
    local three = string.char(math.floor(x / 65536), math.floor(x / 256) % 256, x % 256)
    out[#out + 1] = not digits[c] and three:sub(1, 1) or not digits[d] and three:sub(1, 2) or three
  end
  return table.concat(out)
end

--- Writes what the window shows to a .png file.
function browser:screenshot(path)
  local shot = self:call("Page.captureScreenshot", { format = "png" })
  local file = assert(io.open(path, "wb"))
  file:write(browser.decoded(shot.data))
  file:close()
  return path
end

--- A pointer's event: "mousePressed", "mouseMoved", "mouseReleased", "mouseWheel".
function browser:mouse(kind, x, y, more)
  local p = { type = kind, x = x, y = y, button = "left", buttons = kind == "mouseReleased" and 0 or 1, clickCount = 1 }
  for key, v in pairs(more or {}) do p[key] = v end
  self:call("Input.dispatchMouseEvent", p)
end

function browser:key(key)
  self:call("Input.dispatchKeyEvent", { type = "keyDown", key = key, text = #key == 1 and key or nil })
  self:call("Input.dispatchKeyEvent", { type = "keyUp", key = key })
end

--- Ends the browser and removes its folder.
function browser:close()
  if not self.gone then
    self.to:write '{"id":0,"method":"Browser.close"}\0'
    self.to:flush()
    while self.from:read(65536) do end
  end
  self.to:close()
  self.from:close()
  scratch.shell(("for i in 1 2 3 4 5 6 7 8 9 10; do rm -rf %s 2>/dev/null && break; sleep 0.1; done"):format(
    scratch.quote(self.folder.path)))
end

return browser
