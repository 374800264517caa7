--- Pictures for specs, and ways to spoil files.

local patience = require "spec.support.patience"

local pictures = {}

--- A small generator of its own: the same numbers under every Lua.
function pictures.random(seed)
  local state = seed % 2147483646 + 1
  return function()
    state = state * 16807 % 2147483647
    return state / 2147483647
  end
end

--- An array [h][w][c] of random numbers in lo .. hi, as an image with one layer "radiance".
function pictures.noise(ylm, w, h, channels, seed, lo, hi)
  local random, rows = pictures.random(seed), {}
  for y = 1, h do
    rows[y] = {}
    for x = 1, w do
      rows[y][x] = {}
      for c = 1, channels do rows[y][x][c] = (lo or 0) + ((hi or 1) - (lo or 0)) * random() end
    end
  end
  return pictures.image(ylm, rows)
end

--- An image with one layer "radiance" of nested tables [h][w][c].
function pictures.image(ylm, rows)
  local picture = ylm.image { size = { #rows[1], #rows }, layers = { { "radiance", #rows[1][1] } } }
  local layer = picture:layer()
  for y = 1, #rows do
    for x = 1, #rows[1] do
      for c = 1, #rows[1][1] do layer:set(y, x, c, rows[y][x][c]) end
    end
  end
  return picture
end

--- Calls try(text) for every truncation (at most `most` of them) and for a flipped bit in every byte likewise.
function pictures.spoil(text, most, seed, try)
  local random = pictures.random(seed)
  local step = math.max(1, math.floor(#text / most))
  for n = 0, #text - 1, step do try(text:sub(1, n), "truncated to " .. n) end
  for i = 1, #text, step do
    local bit = 2 ^ math.floor(8 * random())
    local byte = text:byte(i)
    byte = math.floor(byte / bit) % 2 == 1 and byte - bit or byte + bit
    try(text:sub(1, i - 1) .. string.char(byte) .. text:sub(i + 1), "byte " .. i .. " altered")
  end
end

--- Runs a Lua script in another process whose files cannot grow beyond a few kilobytes; what it prints.
function pictures.on_full_disk(scratch, script, blocks)
  local lua = os.getenv "YLM_LUA" or "lua5.4"
  return scratch.capture(("trap '' XFSZ; ulimit -f %d; timeout %d %s -e %s"):format(blocks or 2, patience(60), lua,
    scratch.quote(script)))
end

return pictures
