--- csrc/light/moments/gen/moments_<lmax>.h: how the moment kernel of one lmax shares the registers.
--
-- The arithmetic is in csrc/light/moments/special.h. A column is all degrees k of one (m, side), whose polynomials are
-- found by recurrence. The plan says which sums are kept in registers together during one pass over a tile of lights.
-- A column that does not fit is cut, and its recurrence carried over in memory. Two columns of an order that do not fit
-- together are one piece of code, which runs for either side. PLAN is for one channel, PLAN_RGB for three that share the
-- recurrences: its sums are threefold.

local template = require "ylm.codegen.template"
local unpack = table.unpack or unpack

--- The sets of kinds of sums that kernels exist for: bits 1 value, 2 gradient, 4 Hessian (moments/moments.h).
local sets = { 1, 3, 4, 5, 7 }
--- Sums that fit into registers beside the rest, of 32 and of 16: YLM__SUMS of csrc/light/moments/calibration.h.
local budgets = { { 24, "defined(__AVX512F__) || defined(__aarch64__)" }, { 12 } }

local function has_bit(set, kind) return math.floor(set / 2 ^ kind) % 2 == 1 end

--- Is there a sum of `kind` at degree k? As ylm__has in moments/moments.h.
local function has(lmax, set, kind, k)
  if not has_bit(set, kind) then return false end
  if kind == 0 then return k <= lmax end
  if kind == 1 then return k >= 1 and k <= lmax + 1 end
  return k ~= 1 and k <= lmax + 2
end

local function degree(lmax, set)
  return has_bit(set, 2) and lmax + 2 or has_bit(set, 1) and lmax + 1 or lmax
end

--- The number of sums at degree k.
local function width(lmax, set, k)
  local n = 0
  for kind = 0, 2 do if has(lmax, set, kind, k) then n = n + 1 end end
  return n
end

--- Passes { first =, count =, { m, side, k0, k1, offset }, ... } with at most `budget` sums each. Where sides share code,
-- the first pass of a column has `apart`, the sums of a side, and the last one is `last`.
local function plan_with(lmax, set, budget, shared)
  local top, passes, pass, first = degree(lmax, set), {}, nil, 0
  local function close()
    if not pass then return end
    passes[#passes + 1] = pass
    first, pass = first + pass.count, nil
  end
  local function sums_of(m)
    local total = 0
    for j = m, top do total = total + width(lmax, set, j) end
    return total
  end
  local function place_column(m, side)
    local total, k = sums_of(m), m
    if pass and pass.count + total > budget then close() end
    while k <= top do
      pass = pass or { first = first, count = 0 }
      local segment = { m, side, k, k, pass.count }
      while k <= top and pass.count + width(lmax, set, k) <= budget do
        pass.count, k = pass.count + width(lmax, set, k), k + 1
      end
      segment[4] = k
      pass[#pass + 1] = segment
      if k <= top then close() end
    end
  end
  local function place_both(m)
    close()
    local began, apart = #passes + 1, sums_of(m)
    place_column(m, "side")
    close()
    passes[began].apart, passes[#passes].last = apart, true
    first = first + apart
  end
  for m = 0, top do
    if shared and m > 0 and 2 * sums_of(m) > budget then place_both(m)
    else
      place_column(m, 0)
      if m > 0 then place_column(m, 1) end
    end
  end
  close()
  return passes
end

--- The number of passes that run.
local function count(passes)
  local n, both = 0, false
  for _, pass in ipairs(passes) do
    both = both or pass.apart ~= nil
    n = n + (both and 2 or 1)
    if pass.last then both = false end
  end
  return n
end

--- Sides share code unless more than a twentieth more passes run so.
local function plan(lmax, set, budget)
  local shared, single = plan_with(lmax, set, budget, true), plan_with(lmax, set, budget, false)
  return count(shared) <= 1.05 * count(single) and shared or single
end

--- Vector operations per light, multiply-adds counted once: sums, and recurrences in z.
local function operations(lmax, set)
  local top, sums, recurrences = degree(lmax, set), 0, 0
  for m = 0, top do
    for k = m, top do
      local sides = m > 0 and 2 or 1
      sums = sums + sides * width(lmax, set, k)
      if k < top and k > 0 then recurrences = recurrences + sides * (k == m and 1 or 2) end
    end
  end
  return sums, recurrences
end

--- The words of a segment of a column, in the order of its degrees.
local function segment_words(words, lmax, set, segment)
  local m, side, k0, k1, sum = unpack(segment)
  words[#words + 1] = k0 > m and "RESUME" or ("COLUMN(%d, %s)"):format(m, side)
  for k = k0, k1 - 1 do
    local kinds = 0
    for kind = 0, 2 do if has(lmax, set, kind, k) then kinds = kinds + 2 ^ kind end end
    if kinds > 0 then words[#words + 1] = ("ADD_%d(%d, %d)"):format(kinds, sum, k) end
    if k < degree(lmax, set) then words[#words + 1] = ("UP(%d, %d)"):format(k, m) end
    sum = sum + width(lmax, set, k)
  end
  if k1 <= degree(lmax, set) then words[#words + 1] = "CUT" end
end

local function plan_text(out, name, lmax, set, budget)
  local words = {}
  for _, pass in ipairs(plan(lmax, set, budget)) do
    if pass.apart then words[#words + 1] = ("SIDES(%d)"):format(pass.apart) end
    words[#words + 1] = ("PASS(%d, %d)"):format(pass.first, pass.count)
    for _, segment in ipairs(pass) do segment_words(words, lmax, set, segment) end
    words[#words + 1] = ("END(%d)"):format(pass.count)
    if pass.last then words[#words + 1] = "END_SIDES" end
  end
  template.macro(out, ("#define %s_%d"):format(name, set), words)
end

--- The unit that compiles the kernel of an element type.
local function unit(lmax, dtype)
  return ([[
/* GENERATED by lua/ylm/codegen/moments.lua; do not edit: make gen writes it anew.
** The moment kernel of lmax %d in %s. */
%s#include "moments_%d.h"

#include "../special.h"
]]):format(lmax, dtype, dtype == "float" and "#define YLM_REAL_IS_FLOAT\n" or "", lmax)
end

--- The plans of an lmax, or the unit of an element type: { lmax, dtype }.
return function(what)
  local lmax, dtype = what[1], what[2]
  if dtype then return unit(lmax, dtype) end
  local out = { "/* GENERATED by lua/ylm/codegen/moments.lua; do not edit: make gen writes it anew." }
  out[#out + 1] = ("** Plans of the moment kernels of lmax %d. Vector operations per light in the sums:"):format(lmax)
  for _, set in ipairs(sets) do
    local sums, recurrences = operations(lmax, set)
    out[#out + 1] = ("**   kinds %d: %4d sums, %4d for polynomials in z"):format(set, sums, recurrences)
  end
  out[#out + 1] = "*/"
  out[#out + 1] = ("#ifndef YLM_LIGHT_MOMENTS_%d_H"):format(lmax)
  out[#out + 1] = ("#define YLM_LIGHT_MOMENTS_%d_H"):format(lmax)
  out[#out + 1] = ("#define LMAX %d"):format(lmax)
  for i, budget in ipairs(budgets) do
    out[#out + 1] = i == 1 and "#if " .. budget[2] or "#else"
    for _, set in ipairs(sets) do plan_text(out, "PLAN", lmax, set, budget[1]) end
    for _, set in ipairs(sets) do plan_text(out, "PLAN_RGB", lmax, set, budget[1] / 3) end
  end
  out[#out + 1] = "#endif"
  out[#out + 1] = ("#define KERNEL_NAME YLM_REAL_KERNEL(ylm__moments_%d)"):format(lmax)
  out[#out + 1] = "#endif"
  return table.concat(out, "\n") .. "\n"
end
