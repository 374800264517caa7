--- Parts of ylm that were not built, since what they need is not installed: specs that ask for one are skipped, not failed.

local lacking = {}

local parts = { "scene" }

--- Notes which parts a spec file asks for in vain.
function lacking.watch()
  for _, part in ipairs(parts) do
    local file = io.open(("%s/lib/libylm_%s.so"):format(os.getenv "YLM_BUILD" or "build", part))
    if file then file:close()
    else
      package.preload["ylm.c." .. part] = function()
        lacking.part = part
        error(("libylm_%s is not built"):format(part), 0)
      end
    end
  end
end

--- Looks for a missing part in what the command line answered.
function lacking.read(text)
  for _, part in ipairs(parts) do
    if package.preload["ylm.c." .. part] and text:find("needs libylm_" .. part, 1, true) then lacking.part = part end
  end
end

return lacking
