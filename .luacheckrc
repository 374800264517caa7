std = "max"
max_line_length = 130
ignore = { "581" } -- not (x > y) says what to do with NaN
files["spec/**/*_spec.lua"] = { std = "max+busted" }
files["spec/support/refusals/*.lua"] = { max_line_length = 160 } -- one case a line
exclude_files = { "build/**", "out/**" }

-- Scene files know constructors by name.
local constructors = {}
for _, list in ipairs { dofile "lua/ylm/contents.lua", dofile "lua/ylm/light/kinds.lua" } do
  for _, entry in ipairs(list) do
    for i = 2, #entry do constructors[#constructors + 1] = entry[i] end
  end
end
files["examples/scenes"] = { read_globals = constructors }
