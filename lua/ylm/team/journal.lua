--- Journals of sweeps: results that are kept as soon as they are there, each with a checksum.
--
-- Process 1 writes PATH, process k writes PATH.k: file systems of clusters do not let several append to one file. Process 1
-- joins them when a sweep begins and when it has ended. The tail of an entry that a killed process has left is passed over.
--
--     ylm journal 1
--     case KEY BYTES CRC          -- KEY: checksum of the case; BYTES and CRC: of the text on the next line
--     TEXT

local core = require "ylm.c.core"

local journal = {}

local HEADER = "ylm journal 1\n"

local function entry(key, text) return ("case %s %d %s\n"):format(key, #text, core.team_crc(text)) .. text .. "\n" end

local function text_of(path)
  local file = io.open(path, "rb")
  if not file then return nil end
  local text = file:read "*a"
  file:close()
  return text
end

local function part(path, rank) return rank == 1 and path or ("%s.%d"):format(path, rank) end

--- Adds the entries of a file's text to `found`, by key; nil, message, code where it is no journal.
local function read(path, text, found)
  if #text < #HEADER and HEADER:sub(1, #text) == text then return found end -- its process was killed at once
  local version = text:match "^ylm journal (%d+)\n"
  if not version then return nil, path .. ": not a journal of team:each", "EFORMAT" end
  if version ~= "1" then return nil, ("%s: a journal of a newer ylm (form %s)"):format(path, version), "EVERSION" end
  local at = #HEADER + 1
  while true do
    local begin, _, key, bytes, crc, first = text:find("case (%x+) (%d+) (%x+)\n()", at)
    if not begin then return found end
    local payload = text:sub(first, first + bytes - 1)
    if #payload == tonumber(bytes) and core.team_crc(payload) == crc then
      found[key], at = payload, first + bytes + 1
    else
      at = first
    end
  end
end

--- Texts by key of a journal and its parts, and the number of parts; or nil, message, code. No journal: none.
function journal.read(path)
  local found, parts = {}, 0
  while true do
    local name = part(path, parts + 1)
    local text = text_of(name)
    if not text and parts > 0 then return found, parts end
    local good, message, code = read(name, text or "", found)
    if not good then return nil, message, code end
    parts = parts + 1
  end
end

--- Writes one file of all texts, sorted by key, and removes the parts; true, or nil, message, code.
function journal.join(path, found, parts)
  local keys, out = {}, { HEADER }
  for key in pairs(found) do keys[#keys + 1] = key end
  table.sort(keys)
  for _, key in ipairs(keys) do out[#out + 1] = entry(key, found[key]) end
  local good, message, code = core.file_save(path, table.concat(out))
  if not good then return nil, message, code end
  for rank = parts, 2, -1 do os.remove(part(path, rank)) end
  return true
end

local function failed(path, message)
  return nil, ("%s cannot be written: %s"):format(path, message or "unknown error"), "EIO"
end

--- A process's file, to be added to; or nil, message, code. It exists from now on, so that no number is left out.
function journal.open(path, rank)
  local name = part(path, rank)
  local file, message = io.open(name, "ab")
  if not file then return failed(name, message) end
  local good
  if rank > 1 then
    good, message = file:write(HEADER)
    good = good and file:flush()
  end
  if rank > 1 and not good then return failed(name, message) end
  return { file = file, name = name }
end

--- Keeps a result; true, or nil, message, code.
function journal.add(j, key, text)
  local good, message = j.file:write(entry(key, text))
  if good then good, message = j.file:flush() end
  if not good then return failed(j.name, message) end
  return true
end

function journal.close(j) j.file:close() end

return journal
