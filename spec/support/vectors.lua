--- Reference vectors of spec/data: read, grouped, compared.

local core = require "ylm.c.core"
local ylm = require "ylm"

local vectors = {}

local function numbers(line)
  local t = {}
  for word in line:gmatch("%S+") do t[#t + 1] = tonumber(word) end
  return t
end

--- Rows of numbers of a file, without comments.
function vectors.rows(path)
  local rows = {}
  for line in assert(io.open(path)):lines() do
    if not line:match("^#") and line:match("%S") then rows[#rows + 1] = numbers(line) end
  end
  return rows
end

--- Sets { lmax =, points = list, records = list per point } of a file with the columns
-- vx vy vz l m value gx gy gz hxx hxy hxz hyy hyz hzz; one set for each highest degree.
function vectors.sh(path)
  local points, order = {}, {}
  for _, r in ipairs(vectors.rows(path)) do
    local key = ("%.17g %.17g %.17g"):format(r[1], r[2], r[3])
    local p = points[key]
    if not p then
      p = { at = { r[1], r[2], r[3] }, lmax = 0, records = {} }
      points[key] = p
      order[#order + 1] = p
    end
    p.lmax = math.max(p.lmax, r[4])
    p.records[#p.records + 1] = r
  end
  local sets, by_lmax = {}, {}
  for _, p in ipairs(order) do
    local set = by_lmax[p.lmax]
    if not set then
      set = { lmax = p.lmax, points = {}, records = {} }
      by_lmax[p.lmax] = set
      sets[#sets + 1] = set
    end
    set.points[#set.points + 1] = p.at
    set.records[#set.records + 1] = p.records
  end
  return sets
end

local width, first = { 1, 3, 6 }, { 6, 7, 10 }

--- The largest difference to the reference, of each order of derivatives, relative to the largest
-- component of its point and degree. `results` are arrays [n][count][..], or lists of rows.
function vectors.compare(set, results)
  local worst = { 0, 0, 0 }
  for k = 1, #results do
    for i, records in ipairs(set.records) do
      local row = results[k][i]:totable()
      local largest, difference = {}, {}
      for _, r in ipairs(records) do
        local l, at = r[4], r[4] * (r[4] + 1) + r[5] + 1
        for c = 1, width[k] do
          local wanted = r[first[k] + c - 1]
          local got = k == 1 and row[at] or row[at][c]
          local d = math.abs(got - wanted)
          if d ~= d then d = math.huge end
          largest[l] = math.max(largest[l] or 0, math.abs(wanted))
          difference[l] = math.max(difference[l] or 0, d)
        end
      end
      for l, d in pairs(difference) do
        local scale = largest[l]
        if scale == 0 then scale = 1 end
        worst[k] = math.max(worst[k], d / scale)
      end
    end
  end
  return worst
end

--- n rows of coefficients in -1 .. 1 up to degree lmax as an array, by math.random as it is seeded.
function vectors.random(n, lmax, dtype)
  local rows = {}
  for i = 1, n do
    rows[i] = {}
    for k = 1, (lmax + 1) ^ 2 do rows[i][k] = 2 * math.random() - 1 end
  end
  return ylm.array(rows, dtype)
end

--- Norm of the difference of two arrays over the norm of b.
function vectors.relative(a, b)
  local _, difference, norm = core.array_distance(a, b)
  return difference / norm
end

return vectors
