-- Files that are saved: through links, with the modes that were there, under any name, whole after a kill, nothing left over.

local core = require "ylm.c.core"
local long = require "spec.support.long"
local scratch = require "spec.support.scratch"
local ylm = require "ylm"

local quote, shell, capture = scratch.quote, scratch.shell, scratch.capture
local lua = os.getenv "YLM_LUA" or "lua5.4"

local PREFIX = ".ylm-unfinished-"

describe("saving", function()
  local folder
  before_each(function() folder = scratch.new() end)
  after_each(function()
    shell("chmod -R u+rwX " .. quote(folder.path))
    folder:remove()
  end)

  --- Runs a shell command in the folder; returns what it prints, which must be good.
  local function sh(command)
    local out, status = capture(("cd %s && { %s\n}"):format(quote(folder.path), command))
    assert.equal(0, status, command .. ": " .. out)
    return out
  end

  local function path(name) return folder.path .. "/" .. name end
  local function save(name) return ylm.array { 1, 2 }:save(path(name)) end
  local function modes(names) return (sh("stat -c %a " .. names):gsub("%s+", " "):gsub(" $", "")) end

  it("goes through links: the link stays, the file behind it is replaced", function()
    sh "mkdir real; echo old >real/a.npy; ln -s real/a.npy one.npy; ln -s one.npy two.npy; ln -s real links"
    assert.is_true(save "two.npy")
    assert.equal("one.npy\nreal/a.npy", (sh "readlink two.npy one.npy":gsub("\n$", "")))
    assert.same({ 1, 2 }, ylm.load(path "real/a.npy"):totable())
    assert.is_true(save "links/b.npy")
    assert.equal("a.npy\nb.npy", (sh "ls -A real":gsub("\n$", "")))
  end)

  it("makes the file that a link leads to, and says where one leads to nothing", function()
    sh "mkdir real; ln -s real/new.npy dangling.npy; ln -s nowhere/new.npy lost.npy; ln -s loop.npy loop.npy"
    assert.is_true(save "dangling.npy")
    assert.same({ 1, 2 }, ylm.load(path "real/new.npy"):totable())
    local ok, message, code = save "lost.npy"
    assert.is_nil(ok)
    assert.equal("EIO", code)
    assert.truthy(message:find("lost.npy: cannot be created: No such file or directory (it is a link to ", 1, true), message)
    ok, message = save "loop.npy"
    assert.is_nil(ok)
    assert.truthy(message:find("Too many levels of symbolic links", 1, true), message)
  end)

  it("keeps the mode of a file that was there and gives new ones what the umask leaves", function()
    sh "for m in 600 640 664 755; do echo >$m.npy; chmod $m $m.npy; done"
    for _, m in ipairs { 600, 640, 664, 755 } do assert.is_true(save(m .. ".npy")) end
    assert.equal("600 640 664 755", modes "600.npy 640.npy 664.npy 755.npy")
    local script = folder:write("new.lua", ([[assert(require "ylm".zeros { 1 }:save(%q .. arg[1]))]]):format(path ""))
    for mask, mode in pairs { ["022"] = "644", ["077"] = "600", ["002"] = "664" } do
      assert.equal("", (capture(("umask %s; %s %s %s.npy"):format(mask, lua, quote(script), mask))))
      assert.equal(mode, modes(mask .. ".npy"))
    end
  end)

  it("keeps owner and group where it may", function()
    if not capture "id -u" :find "^0" then return pending "only root may give files away" end
    sh "echo >a.npy; chmod 640 a.npy; chown 12345:23456 a.npy"
    assert.is_true(save "a.npy")
    assert.equal("12345 23456 640", (sh "stat -c '%u %g %a' a.npy":gsub("\n$", "")))
  end)

  it("opens a file to nobody else where it may not give the group", function()
    local as = "setpriv --reuid 12345 --regid 12345 --groups 23456 "
    if not shell(as .. "true 2>/dev/null") then return pending "only root may become somebody else" end
    sh "chmod 777 .; echo >a.npy; chmod 660 a.npy; chown 12345:34567 a.npy"
    local script = ([[assert(require "ylm".zeros { 1 }:save(%q))]]):format(path "a.npy")
    if not shell(as .. lua .. " -e 'require [[ylm]]' 2>/dev/null") then return pending "this tree is root's alone" end
    assert.equal("", (capture(as .. lua .. " -e " .. quote(script))))
    assert.equal("12345 12345 600", (sh "stat -c '%u %g %a' a.npy":gsub("\n$", "")))
  end)

  it("takes names of up to 255 bytes and says that one is too long", function()
    local name = ("n"):rep(251) .. ".npy"
    assert.is_true(save(name))
    assert.is_true(save(name)) -- again, over itself
    assert.same({ 1, 2 }, ylm.load(path(name)):totable())
    local ok, message, code = save("n" .. name)
    assert.is_nil(ok)
    assert.equal("EIO", code)
    assert.truthy(message:find "cannot be created: File name too long", message)
  end)

  it("refuses what is no file", function()
    sh "mkdir dir.npy; mkfifo pipe.npy"
    for _, name in ipairs { "dir.npy", "pipe.npy" } do
      local ok, message = save(name)
      assert.is_nil(ok)
      assert.truthy(message:find(name .. ": exists and is not a regular file", 1, true), message)
    end
  end)

  it("refuses a file without its write bit, and one in a folder without its own", function()
    local prefix = ""
    if capture "id -u" :find "^0" then
      prefix = "setpriv --bounding-set=-dac_override,-dac_read_search "
      if not shell(prefix .. "true 2>/dev/null") then return pending "root cannot be held to permissions here" end
    end
    sh "mkdir shut; echo kept >shut/a.npy; chmod 555 shut; echo kept >b.npy; chmod 444 b.npy"
    local script = folder:write("both.lua", ([[
      for _, name in ipairs { "shut/a.npy", "b.npy" } do print(require "ylm".zeros { 1 }:save(%q .. name)) end]]):format(path ""))
    local out = capture(("%s%s %s"):format(prefix, lua, quote(script)))
    assert.truthy(out:find("shut/a.npy: cannot be written: the new file is made beside the old one before it takes its place, "
      .. "and that folder takes none: Permission denied\tEIO\n", 1, true), out)
    assert.truthy(out:find("b.npy: cannot be written: Permission denied\tEIO", 1, true), out)
    assert.equal("kept\nkept", (sh "cat shut/a.npy b.npy":gsub("\n$", "")))
  end)

  it("leaves the old file whole when its process is killed, and the name free", function()
    local ready = path "ready"
    local script = folder:write("endless.lua", ([[
      local a = require "ylm".zeros({ 400000 })
      assert(a:save(%q))
      io.open(%q, "w"):close()
      while true do assert(a:save(%q)) end]]):format(path "a.npy", ready, path "a.npy"))
    for round = 1, long(4, 49) do
      os.remove(ready)
      capture(("%s %s & p=$!; while [ ! -e %s ]; do sleep 0.01; done; sleep 0.%03d; kill -9 $p; wait $p 2>/dev/null; true")
        :format(lua, quote(script), quote(ready), 20 * round % 101))
      assert.equal(400000, #ylm.load(path "a.npy"))
    end
    assert.is_true(save "a.npy")
  end)

  --- A file as a killed process leaves it, changed so many minutes ago.
  local function left(name, minutes)
    folder:write(name, "unfinished")
    sh(("touch -d '%d minutes ago' %s"):format(minutes, quote(name)))
  end

  local function names() return sh "ls -A | LC_ALL=C sort":gsub("%s+", " "):gsub(" $", "") end

  it("removes what killed processes left an hour ago, and nothing else", function()
    local digits = "0123456789ab"
    left(PREFIX .. digits, 61)
    left(PREFIX .. "000000000000", 50)            -- too young
    left(PREFIX .. digits .. "c", 99)             -- other names
    left(PREFIX .. digits .. ".npy", 99)
    left("x" .. PREFIX .. digits, 99)
    left(".ylm-unfinished", 99)
    sh((("echo kept >other; touch -d '2 hours ago' other; ln other Xaaaaaaaaaaaa; ln -s other Xbbbbbbbbbbbb; "
      .. "mkdir Xcccccccccccc; touch -h -d '2 hours ago' Xbbbbbbbbbbbb Xcccccccccccc"):gsub("X", PREFIX)))
    local gone = PREFIX .. digits .. " "
    local first, last = names():find(gone, 1, true)
    local rest = names():sub(1, first - 1) .. names():sub(last + 1)
    assert.is_true(save "a.npy")
    assert.equal(rest, (names():gsub(" a.npy", "")))
  end)

  it("leaves what a living process still writes, however old", function()
    if not shell "command -v flock >/dev/null" then return pending "without flock(1)" end
    left(PREFIX .. "dddddddddddd", 90)
    sh(("flock -x %sdddddddddddd sh -c 'touch locked; sleep 0.5' >/dev/null 2>&1 & "):format(PREFIX)
      .. "while [ ! -e locked ]; do sleep 0.01; done")
    assert.is_true(save "a.npy")
    assert.truthy(names():find(PREFIX .. "dddddddddddd", 1, true))
  end)

  it("of text goes the same way: ylm codegen -o", function()
    sh "echo old >real.c; chmod 600 real.c; ln -s real.c link.c"
    local tool = (os.getenv "YLM_BUILD" or "build") .. "/ylm"
    local out, status = capture(("YLM_LUA=%s LUA_PATH= LUA_CPATH= %s codegen --lmax 0 -o %s"):format(lua, quote(tool),
      quote(path "link.c")))
    assert.equal(0, status, out)
    assert.equal("600", modes "real.c")
    assert.truthy(folder:read "real.c":find("generated", 1, true) or #folder:read "real.c" > 100)
    assert.is_true(core.file_save(path "t.txt", "a\0b"))
    assert.equal("a\0b", folder:read "t.txt")
  end)
end)
