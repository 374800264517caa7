-- Line plots as SVG and PDF: text stays text, and the page looks as the pixels do.

local lines = require "ylm.plot.lines"
local picture = require "ylm.picture"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

if not picture.vtk() then
  describe("plot:save by lines", function() it("draws", function() pending "VTK is not built in" end) end)
  return
end

local function plot(more)
  local fields = { size = { 480, 320 }, title = "Error of ‖∇L₀₀‖ & more", x_label = "probes", y_label = "error <W m⁻²>",
    log = true, font = 12,
    series = { { x = { 1, 10, 100 }, y = { 1e-4, 1e-3, 1.5e-2 }, label = "measured µ" },
               { x = { 1, 100 }, y = { 1e-3, 1e-2 }, label = "asked", dash = "dashed", marker = "cross" } } }
  for key, value in pairs(more or {}) do fields[key] = value end
  return ylm.plot(fields)
end

describe("plot:save by lines", function()
  local folder
  setup(function() folder = scratch.new() end)
  teardown(function() folder:remove() end)

  it("writes SVG whose words are words", function()
    assert(plot():save(folder.path .. "/a.svg"))
    local text = folder:read "a.svg"
    for _, word in ipairs { "Error of ‖∇L", " &amp; more", "error &lt;W m", "measured µ", "asked", "probes" } do
      assert(text:find(word, 1, true), word)
    end
    assert(text:find '^<svg [^>]*width="480" height="320"' and text:find "</svg>\n$")
    local open = 0
    for tag in text:gmatch "<[^>]+>" do
      if tag:find "^</" then open = open - 1 elseif not tag:find "/>$" then open = open + 1 end
    end
    assert.equal(0, open)
  end)

  it("puts points where plot:where says", function()
    local p = plot()
    assert(p:save(folder.path .. "/b.svg"))
    local text, x, y = folder:read "b.svg", p:where(10, 1e-3)
    local best = math.huge
    for points in text:gmatch '<polyline points="([^"]+)"' do
      for px, py in points:gmatch "([%d.]+),([%d.]+)" do
        best = math.min(best, math.abs(px - x) + math.abs(py - y))
      end
    end
    assert(best < 0.02, best)
  end)

  it("cuts lines at the axes", function()
    local p = plot { log = false, x_range = { 0, 10 }, y_range = { 0, 10 }, title = "t",
      series = { { x = { -5, 5, 15 }, y = { 5, 5, 25 }, marker = "none" } } }
    assert(p:save(folder.path .. "/c.svg"))
    local left, bottom = p:where(0, 0)
    local right, top = p:where(10, 10)
    for points in folder:read("c.svg"):gmatch '<polyline points="([^"]+)"[^>]* stroke%-width="2.2"' do
      for x, y in points:gmatch "([%d.]+),([%d.]+)" do
        local px, py = tonumber(x), tonumber(y)
        assert(px > left - 0.02 and px < right + 0.02 and py > top - 0.02 and py < bottom + 0.02, points)
      end
    end
  end)

  it("writes PDF whose words are found and whose page is the picture", function()
    local path = folder.path .. "/a.pdf"
    local ok, message, code = plot { size = { 960, 640 } }:save(path)
    if code == "EMISSING" then pending(message) end
    assert(ok, message)
    if not scratch.shell "command -v pdftotext >/dev/null && command -v pdftoppm >/dev/null" then
      pending "poppler-utils is not installed"
    end
    local text = scratch.capture("pdftotext -layout " .. scratch.quote(path) .. " - 2>/dev/null")
    for _, word in ipairs { "measured µ", "asked", "probes", "10⁻³", "& more" } do assert(text:find(word, 1, true), word) end
    assert(scratch.shell(("cd %s && pdftoppm -r 72 -png a.pdf page 2>/dev/null"):format(scratch.quote(folder.path))))
    assert(plot { size = { 960, 640 } }:save(folder.path .. "/a.png"))
    local page = assert(ylm.load(folder.path .. "/page-1.png"))
    local m = page:compare(assert(ylm.load(folder.path .. "/a.png")), { peak = 1 })
    assert(m.ssim >= 0.9, m.ssim)
  end)

  it("keeps the old file where it fails", function()
    local ok, message, code = plot():save(folder.path .. "/no/such/folder.svg")
    assert(ok == nil and code == "EIO", message)
    ok, message, code = plot():save(folder.path .. "/no/such/folder.pdf")
    assert(ok == nil and (code == "EIO" or code == "EMISSING"), message)
    assert.has_error(function() plot():save(folder.path .. "/a.eps") end,
      "bad argument #1 to 'save' (the name of a .png, .svg or .pdf file expected, got '" .. folder.path .. "/a.eps')")
  end)
end)

describe("lines.svg", function()
  it("writes numbers short and colours as hexadecimal", function()
    local text = lines.svg({ { points = { 0, 1.25, 10, 2 }, colour = { 1, 0.5, 0, 0.25 }, width = 1.5 } }, 10, 10)
    assert(text:find('<polyline points="0,1.25 10,2" fill="none" stroke="#ff8000" stroke-opacity="0.25" '
      .. 'stroke-width="1.5"/>', 1, true), text)
  end)
end)
