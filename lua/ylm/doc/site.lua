--- Pages of docs for the site that LDoc makes: links and pictures that lead somewhere there too.
--
--     ylm run lua/ylm/doc/site.lua FROM TO      the site of the tree FROM, made by LDoc, into the folder TO
--     ylm run lua/ylm/doc/site.lua --check DIR  ends with status 1 where a link or a picture of DIR leads nowhere

local core = require "ylm.c.core"
local reference = require "ylm.doc.pages"

local function read(path)
  local file = assert(io.open(path, "rb"))
  local text = file:read "*a"
  file:close()
  return text
end

local function lines_of(command)
  local pipe, list = assert(io.popen(command)), {}
  for line in pipe:lines() do list[#list + 1] = line end
  pipe:close()
  return list
end

local function quoted(text) return "'" .. text:gsub("'", "'\\''") .. "'" end

--- A path without "x/.." and "./".
local function plain(path)
  local parts = {}
  for part in path:gmatch "[^/]+" do
    if part == ".." and #parts > 0 then parts[#parts] = nil
    elseif part ~= "." then parts[#parts + 1] = part end
  end
  return table.concat(parts, "/")
end

--- The anchor of a heading, as forges make it.
local function slug(heading)
  return (heading:lower():gsub("[^%w%s_\128-\255-]", ""):gsub("%s", "-"))
end

--- The name of a page among LDoc's topics: docs/bench/light.md is bench_light.md.
local function topic(path) return (path:gsub("^docs/", ""):gsub("/", "_")) end

--- The first of the site's pages; others follow by name.
local first_pages = { "README.md", "model.md", "tutorial.md", "how-do-i.md", "gallery.md", "conventions.md",
  "grids.md", "surfaces.md", "math.md" }

-- Making pages -----------------------------------------------------------------------------

--- One page: links lead to topics, headings have the anchors of forges, pictures lie in images/.
local function page(path, text, pages)
  local folder, fenced, out, prose = path:match "^(.*/)" or "", false, {}, {}
  local function link(label, target)
    if target:find "^%a+:" or target:find "^#" then return ("[%s](%s)"):format(label, target) end
    local file, anchor = target:match "^([^#]*)(#?.*)$"
    file = plain(folder .. file)
    if pages[file] then return ("[%s](%s.html%s)"):format(label, topic(file), anchor) end
    if file:find "%.png$" then return ("[%s](images/%s)"):format(label, file:match "[^/]+$") end
    return label                                         -- sources are not part of the site
  end
  local function end_prose() -- labels of links go on in the next line
    if #prose > 0 then out[#out + 1] = table.concat(prose, "\n"):gsub("%[([^%[%]]*)%]%(([^%s%)]+)%)", link) end
    prose = {}
  end
  for line in (text .. "\n"):gmatch "(.-)\n" do
    if line:find "^```" then fenced = not fenced end
    local heading = not fenced and line:match "^##+%s+(.*)$"
    if heading then
      end_prose()
      out[#out + 1] = ('<a id="%s"></a>'):format(slug(heading))
      out[#out + 1] = ""
    end
    if fenced then
      end_prose()
      out[#out + 1] = line
    else
      prose[#prose + 1] = line
    end
  end
  end_prose()
  return table.concat(out, "\n")
end

--- LDoc's input: entries beside the code as modules, pages as topics, and its settings.
local function input(from, to)
  for name, text in pairs(reference.ldoc()) do assert(core.file_save(to .. "/" .. name, text)) end
  local pages = {}
  local names = "*.md docs/*.md docs/bench/*.md csrc/README.md lua/ylm/README.md"
  for _, path in ipairs(lines_of("cd " .. quoted(from) .. " && ls " .. names)) do
    pages[path] = read(from .. "/" .. path)
  end
  local rest, listed = {}, {}
  for _, name in ipairs(first_pages) do listed[name] = true end
  for path, text in pairs(pages) do
    local name = topic(path)
    if not listed[name] then rest[#rest + 1] = name end
    assert(core.file_save(to .. "/" .. name, page(path, text, pages)))
  end
  table.sort(rest)
  local topics = {}
  for _, list in ipairs { first_pages, rest } do
    for _, name in ipairs(list) do topics[#topics + 1] = ("%q"):format(name) end
  end
  assert(core.file_save(to .. "/config.ld", read(from .. "/lua/ylm/doc/config.ld")
    .. "topics = { " .. table.concat(topics, ", ") .. " }\n"))
end

--- Runs shell commands; stops at one that fails.
local function run(...)
  local command = table.concat({ ... }, " && ")
  local ok = os.execute(command)
  if ok ~= true and ok ~= 0 then error("failed: " .. command, 0) end
end

local function make(from, to)
  local images, scratch = quoted(to .. "/topics/images"), to .. "/input"
  run("rm -rf " .. quoted(to), "mkdir -p " .. quoted(to .. "/topics") .. " " .. quoted(scratch))
  input(from, scratch)
  run(("cp -r %s %s"):format(quoted(from .. "/docs/images"), images), "cd " .. quoted(scratch),
    "ldoc -q -c config.ld -d .. . >ldoc.log", "cd ..", "rm -r input")
end

-- Checking ---------------------------------------------------------------------------------

local function check(folder)
  local files, anchors = lines_of("cd " .. quoted(folder) .. " && find . -name '*.html' | sort"), {}
  local function names(path)
    if not anchors[path] then
      anchors[path] = {}
      for name in read(folder .. "/" .. path):gmatch '%s%a+%s*=%s*"[^"]*"' do
        local key, value = name:match '(%a+)%s*=%s*"(.*)"$'
        if key == "id" or key == "name" then anchors[path][value] = true end
      end
    end
    return anchors[path]
  end
  local broken, links = {}, 0
  for _, path in ipairs(files) do
    path = plain(path)
    for key, target in read(folder .. "/" .. path):gmatch '(%a+)%s*=%s*"([^"]*)"' do
      if (key == "href" or key == "src") and not target:find "^%a+:" then
        links = links + 1
        local file, anchor = target:match "^([^#]*)#?(.*)$"
        file = file == "" and path or plain((path:match "^(.*/)" or "") .. file)
        local handle = io.open(folder .. "/" .. file, "rb")
        if handle then handle:close() end
        if not handle or (anchor ~= "" and file:find "%.html$" and not names(file)[anchor]) then
          broken[#broken + 1] = path .. ": " .. target
        end
      end
    end
  end
  return broken, links
end

local first, second = ...
if first == "--check" and second then
  local broken, links = check(second)
  print(("%d links and pictures, %d broken"):format(links, #broken))
  for _, text in ipairs(broken) do print(text) end
  if #broken > 0 or links == 0 then os.exit(1) end
elseif first and second then make(first, second)
else
  io.stderr:write "site.lua: FROM and TO, or --check and a folder expected\n"
  os.exit(2)
end
