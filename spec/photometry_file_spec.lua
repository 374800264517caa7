-- Photometric files, written here by hand from the printed layouts of LM-63 and EULUMDAT: every symmetry, opening and version;
-- what is wrong with a file is said with its line.

local scratch = require "spec.support.scratch"
local ylm = require "ylm"

local folder
setup(function() folder = scratch.new() end)
teardown(function() folder:remove() end)

--- The intensity that all files have at angles in degrees, C within the part that a symmetry stores.
local function candela(c, gamma) return 100 + 2 * gamma + c * gamma / 50 end

--- Where a symmetry shows the plane C: a plane that is stored.
local fold = {
  round = function() return 0 end,
  quarters = function(c)
    c = c % 360
    if c > 180 then c = 360 - c end
    return c > 90 and 180 - c or c
  end,
  halves = function(c)
    c = c % 360
    return c > 180 and 360 - c or c
  end,
  sides = function(c)
    c = c % 360
    return (c < 90 or c > 270) and (180 - c) % 360 or c
  end,
  full = function(c) return c % 360 end,
}

--- Every number of a photometry is candela(fold(C), gamma), times a factor.
local function holds(p, symmetry, factor, planes)
  local v, h, cd = p:table()
  assert.equal(planes, #h)
  for k = 1, #h do
    for j = 1, #v do
      local wanted = factor * candela(fold[symmetry](h:get(k)), v:get(j))
      if v:get(j) == 0 then wanted = factor * 100 end -- a pole has one value
      if v:get(j) == 180 then wanted = cd:get(k, j) end
      assert.is_true(math.abs(cd:get(k, j) - wanted) < 1e-9 * wanted, ("%s C %g gamma %g: %g, wanted %g"):format(symmetry,
        h:get(k), v:get(j), cd:get(k, j), wanted))
    end
  end
end

local function join(list, between)
  local out = {}
  for i, x in ipairs(list) do out[i] = ("%.12g"):format(x) end
  return table.concat(out, between or " ")
end

local function steps(from, to, step)
  local list = {}
  for x = from, to, step do list[#list + 1] = x end
  return list
end

-- LM-63 -----------------------------------------------------------------------------------------

local versions = { "IESNA:LM-63-2002\n[TEST] 7\n[MANUFAC] Ylm\n", "IESNA:LM-63-1995\n[TEST] 7\n[MANUFAC] Ylm\n[MORE] and more\n",
  "IESNA91\n[TEST] 7\n[MANUFAC] Ylm\n", "IES:LM-63-2019\n[TEST] 7\n[MANUFAC] Ylm\n", "a label of 1986\nanother\n" }

--- A file of LM-63 as text: fields of `o` replace what stands here.
local function ies(o)
  local rows = {}
  for _, h in ipairs(o.h) do
    local row = {}
    for i, v in ipairs(o.v) do row[i] = candela(h, v) end
    rows[#rows + 1] = join(row)
  end
  return (o.version or versions[1]) .. (o.tilt or "TILT=NONE") .. "\n"
    .. ("1 %g %g %d %d %d %d %s\n%s %g %g\n"):format(o.lumens or 1000, o.multiplier or 1, #o.v, #o.h, o.type or 1, o.units or 2,
      o.opening or "0 0 0", o.ballast or "1", o.other or 1, o.watts or 20)
    .. join(o.v) .. "\n" .. join(o.h) .. "\n" .. table.concat(rows, "\n") .. "\n"
end

local function load(text, name, given)
  given = given or {}
  given.file = folder:write(name or "lamp.ies", text)
  return ylm.photometry(given)
end

local v90 = steps(0, 90, 15)

describe("IES LM-63", function()
  local forms = {
    { "round", { 0 }, 1 }, { "quarters", steps(0, 90, 30), 12 }, { "halves", steps(0, 180, 30), 12 },
    { "full", steps(0, 360, 30), 12 }, { "sides", steps(90, 270, 30), 12 }, { "full", steps(0, 330, 30), 12 },
    { "halves", { 0, 10, 180 }, 4 } }

  for i, form in ipairs(forms) do
    it("reads planes of form " .. i .. ", " .. form[1] .. ", of every version", function()
      for k, version in ipairs(versions) do
        local full = form[1] == "full" and form[2][#form[2]] == 360
        local h = form[2]
        local text = ies { version = version, v = v90, h = h }
        if full then -- the plane at 360 is that at 0
          local lines = {}
          for line in text:gmatch "[^\n]+" do lines[#lines + 1] = line end
          lines[#lines] = lines[#lines - #h + 1]
          text = table.concat(lines, "\n") .. "\n"
        end
        for _, ending in ipairs { "\n", "\r\n", "\r" } do
          local p = assert(load((text:gsub("\n", ending))))
          holds(p, form[1], 1, form[3])
          assert.equal(1000, p.lumens_file)
          assert.equal(20, p.watts)
          if k ~= 5 then assert.equal("Ylm", p.text.MANUFAC) end
        end
      end
    end)
  end

  it("multiplies by the multiplier and both factors, but not by a mark of 2019", function()
    holds(assert(load(ies { v = v90, h = { 0 }, multiplier = 2, ballast = "0.5", other = 0.9 })), "round", 0.9, 1)
    holds(assert(load(ies { v = v90, h = { 0 }, other = 1.0001 })), "round", 1, 1)
  end)

  it("reads numbers with commas between, in lines that end anywhere", function()
    local text = ies { v = v90, h = { 0 } }
    local head, numbers = text:match "^(.-TILT=NONE\n)(.*)$"
    holds(assert(load(head .. numbers:gsub("%s+", "\n"))), "round", 1, 1)
    holds(assert(load(head .. numbers:gsub("%s+", ", "):gsub(", $", "\n"))), "round", 1, 1)
  end)

  it("reads every opening", function()
    local feet = 0.3048
    for _, case in ipairs {
      { "0 0 0", 2, "point" }, { "0.3 1.2 0", 2, "rectangle", { 1.2, 0.3 } }, { "1 4 0", 1, "rectangle", { 4 * feet, feet } },
      { "0.3 1.2 0.1", 2, "rectangle", { 1.2, 0.3 }, 0.1 }, { "-0.4 0 0", 2, "disk", 0.2 }, { "-0.4 -0.4 0", 2, "disk", 0.2 },
      { "-0.4 -0.4 -0.4", 2, "sphere", 0.2 }, { "-0.4 0 0.5", 2, "disk", 0.2, 0.5 }, { "0 1.2 0", 2, "rectangle", { 1.2, 0.01 } },
      { "-0.4 -0.8 0", 2, "rectangle", { 0.8 * math.sqrt(math.pi / 4), 0.4 * math.sqrt(math.pi / 4) } },
      { "0.2 -0.4 0.2", 2, "rectangle", { 0.4, 0.2 }, 0.2 } } do
      local o = assert(load(ies { v = v90, h = { 0 }, opening = case[1], units = case[2] })).opening
      assert.equal(case[3], o.shape, case[1])
      local size = type(case[4]) == "table" and o.size or { o.radius }
      for i, x in ipairs(type(case[4]) == "table" and case[4] or { case[4] }) do
        assert.is_true(math.abs(size[i] - x) < 1e-12, case[1])
      end
      assert.equal(case[5], o.height, case[1])
    end
  end)

  it("takes factors of TILT=INCLUDE, and of a file beside it, at the tilt that is asked for", function()
    local factors = "1\n3\n0 45 90\n1 0.9 0.7\n"
    folder:write("factors.tlt", factors)
    for _, tilt in ipairs { "TILT=INCLUDE\n" .. factors:sub(1, -2), "TILT=factors.tlt" } do
      local text = ies { v = v90, h = { 0 }, tilt = tilt }
      holds(assert(load(text)), "round", 1, 1)
      holds(assert(load(text, nil, { tilt = 60 })), "round", 0.9 - 0.2 / 3, 1)
    end
    for _, name in ipairs { "missing.tlt", "../factors.tlt", "/etc/passwd" } do
      local ok, message = pcall(load, ies { v = v90, h = { 0 }, tilt = "TILT=" .. name }, nil, { tilt = 10 })
      assert.is_false(ok)
      assert.matches("TILT=", message)
    end
  end)

  it("resamples types B and A onto gamma and C", function()
    -- I = 1000 cos^2 of the angle to the axis: the same table by either polar axis.
    local list, v = steps(-90, 90, 5), {}
    for _, h in ipairs(list) do
      local row = {}
      for i, x in ipairs(list) do row[i] = 1000 * (math.cos(math.rad(h)) * math.cos(math.rad(x))) ^ 2 end
      v[#v + 1] = join(row)
    end
    for kind = 2, 3 do
      local text = versions[1] .. ("TILT=NONE\n1 -1 1 %d %d %d 2 0 0 0 1 1 50\n"):format(#list, #list, kind) .. join(list) .. "\n"
        .. join(list) .. "\n" .. table.concat(v, "\n") .. "\n"
      local p = assert(load(text))
      assert.matches("type " .. (kind == 2 and "B" or "A"), p.notes[#p.notes])
      for g = 0, 90, 7 do
        for c = 0, 350, 37 do
          local t, a = math.rad(g), math.rad(c)
          local got = p:intensity { math.sin(t) * math.cos(a), math.sin(t) * math.sin(a), math.cos(t) }
          assert.is_true(math.abs(got - 1000 * math.cos(t) ^ 2) < 0.5, ("%d %g %g: %g"):format(kind, g, c, got))
        end
      end
      assert.is_nil(p.lumens_file)
    end
  end)

  it("says what is wrong, with the line", function()
    local good = ies { v = v90, h = { 0 } }
    for _, case in ipairs {
      { "", "neither IES LM%-63" }, { "IESNA:LM-63-2002\n[TEST] x\n", "no TILT= in the first 200 lines" },
      { good:gsub("20\n0 15", "20\n15 0", 1), ":%d+: vertical angles must increase" },
      { good:sub(1, -10), ":%d+: the file ends: 7 intensities wanted, %d there" },
      { good:gsub("1 1000 1 7", "1 1000 1 1000000000"), ":5: the number of vertical angles must be an integer from 2 to 3601" },
      { good:gsub("1 1000 1 7", "1 1000 1 -7"), "number of vertical angles must be an integer" },
      { good:gsub("1 1000 1 7", "0 1000 1 7"), "number of lamps must be" },
      { good:gsub("1 1000 1", "1 1000 0"), "multiplier must be" },
      { good:gsub("1 1000", "1 lots"), 'lumens of a lamp: a number expected, got "lots"' },
      { good:gsub("1 1000 1", "1 1000 1e300"), "a number expected" }, { good:gsub("TILT=NONE", "TILT="), "TILT= NONE, INCLUDE" },
      { ies { v = v90, h = { 0, 45 } }, "horizontal angles go from 0 to 45" },
      { ies { v = steps(-10, 90, 10), h = { 0 } }, "within 0 to 180" }, { good .. "\0", "zero byte" },
      { "\255\254" .. good, "UTF%-16" },
      { (good:gsub("(\n0\n)[^\n]*", "%1-1 -1 -1 -1 -1 -1 -1")), "no intensity is above 0" } } do
      local p, message, code = load(case[1])
      assert.is_nil(p, case[2])
      assert.equal("EFORMAT", code, message)
      assert.matches(case[2], message)
    end
  end)

  it("notes what it changes", function()
    for _, case in ipairs {
      { ies { v = v90, h = steps(0, 330, 30) }, "the circle is closed" },
      { ies { v = v90, h = { 0 } } .. "12 13\n", "left out: 1" },
      { ies { v = steps(0, 60, 15), h = { 0 } }, "dark beyond" },
      { (ies { v = v90, h = { 0 } }:gsub("(\n0\n)100", "%1-5")), "negative intensities" } } do
      local p = assert(load(case[1]))
      assert.matches(case[2], table.concat(p.notes, "; "))
    end
  end)
end)

-- EULUMDAT ---------------------------------------------------------------------------------------

--- A file of EULUMDAT as text.
local function ldt(o)
  local planes, angles = o.planes or 12, o.g or steps(0, 90, 15)
  local lines = { "Ylm", o.source or "2", o.symmetry, planes, 360 / planes, #angles, 15, "report", "Lamp", "L-1", "lamp.ldt",
    "today",
    1200, 300, 80, o.length or 1200, o.width or 300, 0, 0, 0, 0, 100, 80, o.factor or 1, 0, o.sets and #o.sets or 1 }
  for _, set in ipairs(o.sets or { { 1, "LED", o.flux or 2000, "4000K", "80", 30 } }) do
    for _, x in ipairs(set) do lines[#lines + 1] = x end
  end
  for _ = 1, 10 do lines[#lines + 1] = 0.5 end
  for k = 1, planes do lines[#lines + 1] = (k - 1) * 360 / planes end
  for _, g in ipairs(angles) do lines[#lines + 1] = g end
  for _, k in ipairs(o.stored) do
    for _, g in ipairs(angles) do lines[#lines + 1] = ("%.12g"):format(candela(k * 360 / planes, g)) end
  end
  for i, x in ipairs(lines) do lines[i] = tostring(x) end
  return table.concat(lines, "\r\n") .. "\r\n"
end

describe("EULUMDAT", function()
  local forms = { { 0, "full", steps(0, 11, 1) }, { 1, "round", { 0 } }, { 2, "halves", steps(0, 6, 1) },
    { 3, "sides", { 9, 10, 11, 0, 1, 2, 3 } }, { 4, "quarters", steps(0, 3, 1) } }

  for _, form in ipairs(forms) do
    it("reads symmetry " .. form[1], function()
      local text = ldt { symmetry = form[1], stored = form[3] }
      local symmetry = form[2]
      -- Planes of symmetry 3 are C270 over C0 to C90.
      local before = fold.sides
      fold.sides = function(c)
        c = c % 360
        return c > 90 and c < 270 and (180 - c) % 360 or c
      end
      for _, shown in ipairs { text, (text:gsub("\r\n", "\n")), (text:gsub("%.", ",")) } do
        local p = assert(load(shown, "lamp.ldt"))
        holds(p, symmetry, 2, symmetry == "round" and 1 or 12)
        assert.equal("EULUMDAT", p.format)
        assert.equal(2000, p.lumens_file)
        assert.equal("Lamp", p.text.luminaire)
      end
      fold.sides = before
    end)
  end

  it("takes the lamp set that is asked for, whichever way sets are laid out", function()
    local a, b = { 1, "one", 1000, "a", "b", 10 }, { 2, "two", 3000, "c", "d", 30 }
    local by_line = { { 1, 2, "one", "two", 1000, 3000 }, { "a", "c", "b", "d", 10, 30 } }
    for _, sets in ipairs { { a, b }, by_line } do
      for i, flux in ipairs { 1000, 3000 } do
        local p = assert(load(ldt { symmetry = 1, stored = { 0 }, sets = sets }, "lamp.ldt", { lamps = i }))
        holds(p, "round", flux / 1000, 1)
        assert.equal(flux / 100, p.watts)
        assert.matches("lamp set " .. i .. " of 2", p.notes[1])
      end
    end
    local p, message = load(ldt { symmetry = 1, stored = { 0 } }, "lamp.ldt", { lamps = 2 })
    assert.is_nil(p)
    assert.matches("lamp set 2 is not there", message)
  end)

  it("has its length along C90, and a width of 0 for a disk", function()
    local o = assert(load(ldt { symmetry = 1, stored = { 0 } }, "lamp.ldt")).opening
    assert.same({ "rectangle", 0.3, 1.2 }, { o.shape, o.size[1], o.size[2] })
    o = assert(load(ldt { symmetry = 1, stored = { 0 }, length = 400, width = 0 }, "lamp.ldt")).opening
    assert.same({ "disk", 0.2 }, { o.shape, o.radius })
  end)

  it("says what is wrong, with the line", function()
    local good = ldt { symmetry = 4, stored = steps(0, 3, 1) }
    for _, case in ipairs {
      { ldt { symmetry = 4, stored = { 0 }, planes = 10 }, ":4: symmetry 4 wants a multiple of 4 planes" },
      { ldt { symmetry = 5, stored = { 0 } }, "the symmetry %(line 3%) must be" }, { good:sub(1, -60), "intensities wanted" },
      { good:gsub("\r\nreport", "\r\n15\r\nreport"), "a number expected" },
      { good:gsub("\r\n100\r\n80", "\r\nmuch\r\n80"), "downward flux" },
      { ldt { symmetry = 1, stored = { 0 }, g = { 0, 30, 20 } }, ":%d+: angles must increase" },
      { (good:gsub("\r\n12\r\n30", "\r\n1000000000\r\n30", 1)), "number of C planes" } } do
      local p, message, code = load(case[1], "lamp.ldt")
      assert.is_nil(p, case[2])
      assert.equal("EFORMAT", code)
      assert.matches(case[2], message)
    end
  end)
end)

describe("photometry:save", function()
  it("writes each symmetry in both formats, the same text when it is read and written again", function()
    for _, form in ipairs { { "round", { 0 } }, { "quarters", steps(0, 90, 30) }, { "halves", steps(0, 180, 30) },
      { "sides", steps(90, 270, 30) }, { "full", steps(0, 330, 30) } } do
      local p = assert(load(ies { v = v90, h = form[2], opening = "0.3 1.2 0" }))
      for _, ending in ipairs { "ies", "ldt" } do
        local a, b = folder.path .. "/a." .. ending, folder.path .. "/b." .. ending
        assert(p:save(a))
        local q = assert(ylm.load(a))
        assert(q:save(b))
        assert.equal(folder:read("a." .. ending), folder:read("b." .. ending))
        local _, _, first = p:table()
        local _, _, second = q:table()
        assert.same(first.shape, second.shape, form[1] .. ending)
        for k = 1, first.shape[1] do
          for j = 1, first.shape[2] do
            assert.is_true(math.abs(first:get(k, j) - second:get(k, j)) < 1e-6 * first:get(k, j))
          end
        end
        assert.same(p.opening, q.opening)
        assert.equal("Ylm", q.text[ending == "ies" and "MANUFAC" or "company"])
      end
    end
  end)
end)

describe("photometric files that end early, or count too much", function()
  it("are refused with a sentence that names a line, wherever they end", function()
    local texts = { ies { v = v90, h = { 0, 90 } }, ldt { symmetry = 4, stored = steps(0, 3, 1) } }
    for i, text in ipairs(texts) do
      local last = #text:gsub("%s+$", "") - 1 -- one digit less may be a number too
      for n = 45, last - 3, 7 do
        local p, message = load(text:sub(1, n), i == 1 and "lamp.ies" or "lamp.ldt")
        assert.is_nil(p, text:sub(1, n))
        assert.matches(":%d+: ", message)
      end
    end
  end)

  it("name the line of 10^9 angles or planes, and of negative ones", function()
    local plain = ldt { symmetry = 4, stored = steps(0, 3, 1) }
    for _, n in ipairs { "1000000000", "-3" } do
      local _, message = load((ies { v = v90, h = { 0 } }:gsub("(TILT=NONE%s+1 %S+ %S+) %d+", "%1 " .. n)))
      assert.matches("the number of vertical angles must be an integer from 2 to 3601", message)
      assert.matches("%.ies:%d+: ", message)
      for line, what in pairs { [4] = "C planes", [6] = "angles" } do
        local k = 0
        local text = plain:gsub("[^\r\n]+", function(x)
          k = k + 1
          return k == line and n or x
        end)
        _, message = load(text, "lamp.ldt")
        assert.matches(("%%.ldt:%d: the number of %s"):format(line, what), message)
      end
    end
  end)
end)
