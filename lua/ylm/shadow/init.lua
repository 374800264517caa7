--- Light behind bodies: ylm.occluder, caster, casters, sphere_casters, shadowed, visibility.

local caster = require "ylm.shadow.caster"
local occluder = require "ylm.shadow.occluder"
local shadowed = require "ylm.shadow.shadowed"
local visibility = require "ylm.shadow.visibility"

return {
  occluder = occluder.occluder, visibility = visibility.visibility,
  caster = caster.caster, casters = caster.casters, sphere_casters = caster.sphere_casters,
  shadowed = shadowed.shadowed, bodies = shadowed.bodies, beside = shadowed.beside,
}
