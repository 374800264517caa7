rockspec_format = "3.0"
package = "ylm"
version = "scm-1"

source = { url = "git+file://." } -- made from a checkout: luarocks make rockspec/ylm-scm-1.rockspec

description = {
  summary = "Spherical-harmonic lighting: SH mathematics, lights, grids of probes, rendering",
  detailed = [[
Evaluates spherical harmonics with first and second derivatives, projects sphere lights analytically,
bakes grids of probes that refine themselves by the Hessian of the light field, renders with them.
Needs a C compiler; OpenEXR and libpng for image files, Embree 3 or 4 for scenes, VTK 9 for pictures of the
mathematics: without them the parts that need them are left out.]],
  license = "MIT",
  labels = { "graphics", "rendering", "math", "spherical-harmonics" },
  -- homepage and issues_url wait for a public address of the tree
}

dependencies = { "lua >= 5.1, < 5.6" } -- and LuaJIT; spec/abi_spec.lua loads each of them
test_dependencies = { "busted >= 2.1" }
test = { type = "command", command = "make spec" }

build = {
  type = "make",
  build_target = "all",
  install_target = "rock",
  build_variables = { ROCK_LUA = "$(LUA)", LUA_CFLAGS = "-I$(LUA_INCDIR)" },
  install_variables = {
    ROCK_LUA = "$(LUA)",
    LUA_CFLAGS = "-I$(LUA_INCDIR)",
    LUADIR = "$(LUADIR)",
    LIBDIR = "$(LIBDIR)",
    BINDIR = "$(BINDIR)",
    ROCK_DIR = "$(PREFIX)",
  },
}
