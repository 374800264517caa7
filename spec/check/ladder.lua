--- The ladder of csrc, as csrc/README.md has it: which folder may include what, which headers are public.

local tree = require "spec.check.tree"

local ladder = {}

--- The ladder of a tree: folders, a list in its order; rank, folder -> its place, equal between braces; rooms, folder -> a list
-- of sub-folders, "room/room" of a room that has some; headers, public header -> its folder.
function ladder.read(root)
  local text = tree.text(root, "csrc/README.md") .. "\n\n"
  local line = assert(text:match "\n    (base <[^\n]*\n[^\n]*)", "csrc/README.md has no lines '    base < ...'")
  local out, place = { folders = {}, rank = {}, rooms = {}, headers = {} }, 0
  for level in (line .. "<"):gmatch "(.-)<" do
    place = place + 1
    for folder in level:gmatch "%w+" do
      out.folders[#out.folders + 1] = folder
      out.rank[folder], out.headers["ylm_" .. folder .. ".h"] = place, folder
      for room in (text:match("\n%*%*" .. folder .. "%*%*.-\n\n") or ""):gmatch "`([%w/]+)/`" do
        out.rooms[folder] = out.rooms[folder] or {}
        table.insert(out.rooms[folder], room)
      end
    end
  end
  for folder, row in text:gmatch "\n| (%l+) |([^\n]*)" do
    for header in row:gmatch "`(ylm_[%w_]+%.h)`" do out.headers[header] = folder end
  end
  return out
end

--- The file that an include of `header` in `path` would be: "csrc/light/tree/far.c", "../light.h" -> "csrc/light/light.h".
function ladder.beside(path, header)
  local place, n = path:match("^(.*/)") .. header, 1
  while n > 0 do place, n = place:gsub("[^/]+/%.%./", "", 1) end
  return place
end

--- Calls f(path, folder, line number, header, "<" or '"') for every include of a tree's C files.
function ladder.each_include(root, f)
  for _, path in ipairs(tree.sources(root)) do
    local folder, n = path:match("^csrc/([^/]+)/"), 0
    for line in io.lines(root .. "/" .. path) do
      n = n + 1
      local kind, header = line:match('^%s*#%s*include%s*([<"])([^>"]+)')
      if header and folder then f(path, folder, n, header, kind) end
    end
  end
end

--- Public headers that the table of csrc/README.md lacks, and names there without a header.
function ladder.headers(root)
  local wrong, known, found = {}, ladder.read(root), {}
  for _, path in ipairs(tree.sources(root)) do
    local folder, name = path:match "^csrc/([^/]+)/(ylm_[%w_]+%.h)$"
    if folder then found[name] = true end
    if folder and known.headers[name] ~= folder then
      wrong[#wrong + 1] = ("%s:1: no header of %s in csrc/README.md"):format(path, folder)
    end
  end
  for name, folder in pairs(known.headers) do
    if not found[name] and name ~= "ylm_" .. folder .. ".h" then
      wrong[#wrong + 1] = ("csrc/README.md:1: %s of %s is not there"):format(name, folder)
    end
  end
  return wrong
end

--- Includes that go up the ladder, or reach a private header of another folder.
function ladder.includes(root)
  local wrong, known, public = {}, ladder.read(root), {}
  for _, path in ipairs(tree.sources(root)) do
    local folder, name = path:match "^csrc/([^/]+)/(ylm_[%w_]+%.h)$"
    if folder then public[name] = folder end
  end
  local function belongs(path, folder) return path:sub(1, #folder + 6) == "csrc/" .. folder .. "/" and tree.exists(root, path) end
  ladder.each_include(root, function(path, folder, n, header, kind)
    local from = public[header] or public[header:match "[^/]+$"]
    local own = belongs(ladder.beside(path, header), folder) or belongs(ladder.beside("csrc/" .. folder .. "/", header), folder)
    if own or kind == "<" and not from then return end
    if not from then wrong[#wrong + 1] = ("%s:%d: %s is no public header"):format(path, n, header)
    elseif from ~= folder and not (known.rank[from] and known.rank[folder] and known.rank[from] < known.rank[folder]) then
      wrong[#wrong + 1] = ("%s:%d: %s includes %s of %s, which is not below it"):format(path, n, folder, header, from)
    end
  end)
  return wrong
end

--- Files in folders that are neither on the ladder nor rooms of one, and public headers within rooms.
function ladder.rooms(root)
  local wrong, known, used = {}, ladder.read(root), {}
  for _, path in ipairs(tree.sources(root)) do
    local folder, room, name = path:gsub("/gen/", "/"):match "^csrc/([^/]+)/(.-)/?([^/]+)$"
    local good = room == ""
    for _, other in ipairs(known.rooms[folder] or {}) do good = good or other == room and not name:find "^ylm_" end
    if not known.rank[folder] then wrong[#wrong + 1] = path .. ":1: its folder is not on the ladder of csrc/README.md"
    elseif not good then wrong[#wrong + 1] = ("%s:1: not in a room that csrc/README.md names of %s"):format(path, folder) end
    if folder then used[folder .. "/" .. room] = true end
  end
  for folder, rooms in pairs(known.rooms) do
    for _, room in ipairs(rooms) do
      if not used[folder .. "/" .. room] then
        wrong[#wrong + 1] = ("csrc/README.md:1: the room %s/%s has no files"):format(folder, room)
      end
    end
  end
  return wrong
end

return ladder
