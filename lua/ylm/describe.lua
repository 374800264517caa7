--- The one source of `ylm help`, the LuaLS annotations and the LDoc pages.
--
--     describe "sh.count" {
--       shelf     = "everyday",                          -- optional: reference.shelves
--       about     = "The number of coefficients of all degrees up to lmax.",
--       arguments = { { "lmax", "integer", "highest degree, 0 or more" } },
--       returns   = { { "count", "integer", "(lmax+1)^2" } },
--       errors    = "raises where lmax is no such integer",
--       example   = "assert(ylm.sh.count(4) == 25)",
--       source    = "Green 2003, p. 12",                 -- optional
--     }
--
-- Optional arguments end in "?". Options of functions are listed as form fields (`options = {...}`,
-- the very table that form.options checks). Methods are named "grid:sample". Every example is run by
-- a spec, with `ylm` as a local.

local reference = { entries = {}, names = {}, objects = {} }

--- The shelves of the interface, in the order in which they are printed: what every user needs, what experiments need,
-- and what exists to compare with. An entry stands on 'experiments' where it names no shelf, an option on its entry's.
reference.shelves = { "everyday", "experiments", "comparison" }
reference.shelf_titles = {
  everyday = "Everyday", experiments = "Experiments", comparison = "Comparison",
}

local known_shelf = {}
for _, shelf in ipairs(reference.shelves) do known_shelf[shelf] = true end

--- The shelf of an entry, a form's definition, or an option of `owner`.
function reference.shelf(x, owner)
  local shelf = x.shelf or owner and owner.shelf or "experiments"
  assert(known_shelf[shelf], "no such shelf: " .. tostring(shelf))
  return shelf
end

local notes = { everyday = "", experiments = "for experiments", comparison = "to compare with" }

--- The words behind a title of options on a shelf that is not their owner's, after `joint`; else "".
function reference.shelf_note(shelf, owner, joint)
  return shelf ~= reference.shelf(owner) and notes[shelf] ~= "" and joint .. notes[shelf] or ""
end

--- A list by shelves, in order: { { shelf, list }, .. } of the shelves that have some of it.
function reference.by_shelf(list, owner)
  local by, out = {}, {}
  for _, x in ipairs(list) do
    local shelf = reference.shelf(x, owner)
    by[shelf] = by[shelf] or {}
    table.insert(by[shelf], x)
  end
  for _, shelf in ipairs(reference.shelves) do
    if by[shelf] then out[#out + 1] = { shelf, by[shelf] } end
  end
  return out
end

--- A described function or object -> its file: a file that is loaded again, because memory ran out at first, describes its
-- own again.
local described_in = {}

local function once(what)
  local home = debug.getinfo(3, "S").source
  assert(not described_in[what] or described_in[what] == home, "described twice: " .. what)
  described_in[what] = home
end

--- Registers the entry of the public function `name` (without the leading "ylm.").
function reference.describe(name)
  once(name)
  return function(entry)
    entry.name = name
    if not reference.entries[name] then reference.names[#reference.names + 1] = name end
    reference.entries[name] = entry
  end
end

--- Registers an object type: about, and fields as { name, type, text } that can be read from it.
--
--     reference.object "array" { about = "...", fields = { { "shape", "table", "its extents" } } }
--
-- `methods = table` where the object is neither a userdata of ylm nor built by a form.
function reference.object(name)
  once("object " .. name)
  return function(entry)
    entry.name = name
    reference.objects[name] = entry
  end
end

return reference
