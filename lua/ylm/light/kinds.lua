--- The kinds of lights: module, then its constructors. A kind is a row here, a form there, a row and a file in csrc/light.
--
-- A form says in `light` how its values become records of csrc/light/kind.h: kind (a name, or a function(values)) and
-- record(values, out), which appends the numbers of one record to `out`. A form without a record, or values without a kind,
-- make a set of lights by themselves: values.lights.

return {
  { "ylm.light.sphere", "sphere_light", "sphere_lights" },
  { "ylm.light.polygon", "polygon_light", "disk_light" },
  { "ylm.light.textured", "textured_light" },
  { "ylm.light.environment", "environment_light" },
  { "ylm.light.sun", "sun_light" },
  { "ylm.light.spot", "spot_light" },
  { "ylm.light.sampled", "sampled_light" },
  { "ylm.light.virtual", "virtual_lights" },
}
