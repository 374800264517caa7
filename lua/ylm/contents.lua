--- The public names: a module, then those that it defines, in the order data flows. light/kinds.lua has those of lights.
-- Also read by .luacheckrc.

return {
  { "ylm.array", "array", "zeros", "stack", "wrap" },
  { "ylm.team", "team" },
  { "ylm.light", "light_field" },
  { "ylm.grid", "adaptive_grid", "uniform_grid", "bake" },
  { "ylm.spheres", "sphere_set" },
  { "ylm.shadow", "occluder", "caster", "casters", "sphere_casters", "shadowed", "visibility" },
  { "ylm.material", "matte", "ggx", "phong", "abc", "merl", "rgl", "tabulated" },
  { "ylm.photometry", "photometry" },
  { "ylm.camera", "camera" },
  { "ylm.gltf", "gltf" },
  { "ylm.transfer", "links" },
  { "ylm.scene", "scene" },
  { "ylm.file", "load" },
  { "ylm.image", "image", "colour" },
  { "ylm.display", "display" },
  { "ylm.render", "true_error" },
  { "ylm.geometry", "quad", "sphere", "box", "torus", "knot", "mesh" },
  { "ylm.view", "view" },
  { "ylm.plot", "plot" },
  { "ylm.plot.polar", "polar_plot" },
  { "ylm.figure", "figure" },
  { "ylm.inverse", "minimise" },
  { "ylm.warning", "on_warning" },
}
