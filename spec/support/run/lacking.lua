--- Parts of ylm that were not built, since what they need is not installed: specs that ask for one are skipped, not failed.

local lacking = {}

local parts = { "codec", "scene", "vtk", "vulkan" }

--- Is the caller's caller ylm.info, which tries all?
local function asked_by_info()
  local level = 2
  while debug.getinfo(level, "n") do
    if debug.getinfo(level, "n").name == "info" then return true end
    level = level + 1
  end
end

--- The parts that were not built.
function lacking.parts()
  local list = {}
  for _, part in ipairs(parts) do
    local file = io.open(("%s/lib/libylm_%s.so"):format(os.getenv "YLM_BUILD" or "build", part))
    if file then file:close() else list[#list + 1] = part end
  end
  return list
end

--- Notes which parts a spec file asks for in vain.
function lacking.watch()
  for _, part in ipairs(lacking.parts()) do
    package.preload["ylm.c." .. part] = function()
      if not asked_by_info() then lacking.part = part end
      error(("libylm_%s is not built"):format(part), 0)
    end
  end
end

--- Notes any part that is missing, after the failure of a program that may use all of them.
function lacking.assume()
  for _, part in ipairs(parts) do
    if package.preload["ylm.c." .. part] then lacking.part = part end
  end
end

--- Looks for a missing part in what the command line answered.
function lacking.read(text)
  for _, part in ipairs(parts) do
    if package.preload["ylm.c." .. part] and text:find("needs? libylm_" .. part) then lacking.part = part end
  end
end

return lacking
