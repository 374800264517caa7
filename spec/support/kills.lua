--- Finished files of bakes in bricks, before and after a kill, and a line about each kill.

local long = require "spec.support.long"
local scratch = require "spec.support.scratch"

local kills = {}

--- The finished files of bricks in a folder, by path: their inodes, which a file that is written anew changes.
function kills.committed(path)
  local found, n = {}, 0
  for _, line in ipairs(scratch.lines(("find %s -name '[0-7]*.a' -printf '%%i %%P\n' -o -name '[0-7]*.ylm' -printf '%%i %%P\n'")
    :format(scratch.quote(path)))) do
    local inode, name = line:match "^(%d+) (.*)$"
    found[name], n = inode, n + 1
  end
  return found, n
end

--- The first file, in no order, that was committed before and is another now; nil: what was done was not done again. Files
-- NAME.a are removed at the end of a bake, which a kill may meet.
function kills.done_again(before, now)
  for name, inode in pairs(before) do
    if now[name] ~= inode and (now[name] or not name:find "%.a$") then return name end
  end
end

--- Says what was killed, when, and what was there; at length only, since the output of the short specs is read by people.
function kills.say(...)
  if long(false, true) then print(string.format(...)) end
end

return kills
