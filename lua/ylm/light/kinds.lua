--- The kinds of lights: module, then its constructors. A kind is a row here, a form there, a row and a file in csrc/light.
--
-- A form says in `light` how its values become records of csrc/light/kind.h: kind (a name, or a function(values)) and
-- record(values, out), which appends the numbers of one record to `out`. A form without a record, or values without a kind,
-- make a set of lights by themselves: values.lights. It may say more, so that no other module knows kinds by name:
--
--   rows(l)          how many lights it counts as; 1 without
--   row, join(rows)  of such a form: the form of each of its lights, and the one that takes these as rows of fields; or nil,
--                    message, code
--   spheres(l)       its lights as rows { at =, radius =, radiance = }, where they are spheres; or nil, message, code
--   moved(l, x)      the same light with the fields x; false: it keeps no fields; pack.moved without
--   outline(l)       the corners of a flat light
--   gltf(w, l)       writes it: lua/ylm/gltf/write.lua says what w does; without, it is left out. Or nil, message, code

return {
  { "ylm.light.sphere", "sphere_light", "sphere_lights" },
  { "ylm.light.polygon", "polygon_light", "disk_light" },
  { "ylm.light.textured", "textured_light" },
  { "ylm.light.environment", "environment_light" },
  { "ylm.light.sun", "sun_light" },
  { "ylm.light.spot", "spot_light" },
  { "ylm.light.photometric", "photometric_light" },
  { "ylm.light.sampled", "sampled_light" },
  { "ylm.light.virtual", "virtual_lights" },
}
