--- Prints each complaint about the tree's architecture, and fails where there is one. Part of make check.
--
--     lua spec/check/main.lua [folder of a tree [names of checks]]

local root, asked, count = arg[1] or ".", {}, 0
for i = 2, #arg do asked[arg[i]] = true end
for _, one in ipairs(require "spec.check.all") do
  local wrong = (#arg < 2 or asked[one[1]]) and one[2](root) or {}
  for _, sentence in ipairs(wrong) do print(sentence) end
  if #wrong > 0 then print(("%s: %d"):format(one[1], #wrong)) end
  count = count + #wrong
end
os.exit(count == 0 and 0 or 1)
