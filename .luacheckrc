std = "max"
max_line_length = 130
ignore = { "581" } -- not (x > y) says what to do with NaN
files["spec/**/*_spec.lua"] = { std = "max+busted" }
files["spec/support/refusals/*.lua"] = { max_line_length = 160 } -- one case a line
exclude_files = { "build/**", "out/**" }
