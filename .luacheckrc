std = "max"
max_line_length = 130
ignore = { "581" } -- not (x > y) says what to do with NaN
files["spec/**/*_spec.lua"] = { std = "max+busted" }
files["spec/support/refusals/*.lua"] = { max_line_length = 160 } -- one case a line
exclude_files = { "build/**", "out/**" }
files["examples/scenes"] = { read_globals = { "scene", "camera", "matte", "ggx", "quad", "box", "sphere", "torus",
  "knot", "mesh", "sphere_light", "sphere_lights",
  "polygon_light", "disk_light", "textured_light", "adaptive_grid", "uniform_grid" } }
