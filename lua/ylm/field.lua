--- Light fields: what has light at points, and what an object may be asked about it.
--
-- A light field is a function f(points, lmax, channels), a light, a list of lights, or an object that C evaluates. field.of
-- wraps them alike:
--
--     local f = field.of(2, "bake", lights)            -- or nil, message, code
--     local quantity, jumps = f:quantity(3, "bake")    -- "lights", "direct" ..; whether it jumps at surfaces
--
-- field.protocol lists the fields of metatables by which an object answers. An object needs none of them but __field.

local check = require "ylm.check"
local core = require "ylm.c.core"
local light = require "ylm.light"

local field = {}

--- The questions that an object may be asked: field of its metatable -> the answer.
field.protocol = {
  -- light fields
  __field = "the function of C by which the field is evaluated",
  __heed = "(field, lmax) -> sentences about what the field does not keep at a degree, said once",
  __counted = "(field) -> the object whose stats count what the field is asked; nil once closed",
  __join = "(lights) -> lights among which this field is, as one field with the metric of bakes",
  __for_bake = "(field, request) -> the field that a bake asks instead, known well enough for its tolerance",
  __for_grid = "(body, description, options) -> options of the bake of a body's visibility, { centre, radius, area }",
  __walls = "(object, name) -> the surfaces that hide light, for bakes and look-ups; of fields and scenes",
  -- places where light is needed
  __positions = "(view, name, device) -> points [n][3] in the memory of the device",
  __normals = "(view, name, flat) -> normals [n][3] at these points, of triangles where flat",
  -- all objects
  __device = "(object) -> the device on which its numbers lie",
  __kind = "the name of the form that made it",
  __names = "() -> the names in a table that loads its parts when they are first used",
}

--- The function that answers a question of the protocol about an object; nil where its kind has none.
local function answer_of(x, question)
  assert(field.protocol[question], question)
  local kind, metatable = core.type(x), type(x) ~= "string" and getmetatable(x)
  return kind ~= "ylm.array" and type(metatable) == "table" and metatable[question] or nil
end

--- The answer of an object to a question of the protocol; nothing where its kind has none.
function field.ask(x, question, ...)
  local answer = answer_of(x, question)
  if answer then return answer(x, ...) end
end

--- The surfaces of a scene or a prepared view, option `scene` of argument `n` of `name`; or nil, message, code.
function field.walls_of_scene(n, name, x)
  local walls, message, code = field.ask(x, "__walls", name)
  if not walls and not message then
    return check.bad(n, name, "scene: a scene or a prepared view expected, got %s", check.describe(x))
  end
  return walls, message, code
end

local methods = {}
local wrapped = { __index = methods }

--- Argument `n` of `name` as a light field, whatever it is; or nil, message, code. f.object is the function, or what C evaluates.
function field.of(n, name, x)
  if type(x) == "function" then return setmetatable({ object = x, is_function = true }, wrapped) end
  local object, message, code = light.field(n, name, x)
  if not object then return nil, message, code end
  return setmetatable({ object = object }, wrapped)
end

--- This field with another object in its place.
function methods:with(object) return setmetatable({ object = object, is_function = self.is_function }, wrapped) end

--- The field with the metric of bakes; or nil, message, code.
function methods:joined()
  if self.is_function then return self end
  local object, message, code = light.joined(self.object)
  if not object then return nil, message, code end
  return self:with(object)
end

--- The quantity that the field holds, `given` where it is a function, and whether it jumps at surfaces.
function methods:quantity(n, name, given)
  if self.is_function then return given or "lights", given ~= nil and given ~= "lights" end
  local quantity, jumps = core.field_quantity(self.object)
  if given and given ~= quantity then
    return check.bad(n, name, "quantity: this light field holds %s, not %s: leave it out", quantity, given)
  end
  return quantity, jumps
end

--- The lights that a dynamic grid can follow; nil where the field is of others.
function methods:followed() return not self.is_function and light.followed(self.object) or nil end

--- The kind of field that a dynamic grid cannot follow, in words.
function methods:other() return light.other(self.object) end

--- Options of the bake of a body's visibility, and the body; nothing where the field is none.
function methods:for_grid(description, options) return field.ask(self.object, "__for_grid", description, options) end

--- Has the field an answer to a question of the protocol?
function methods:answers(question) return answer_of(self.object, question) ~= nil end

--- The field that a bake is to ask: fields that are known to some noise settle that first. Or nil, message, code.
function methods:for_bake(request)
  local object, message, code = field.ask(self.object, "__for_bake", request)
  if object then return self:with(object) end
  if message then return nil, message, code end
  return self
end

--- The surfaces at which its light jumps; nil where it tells none. Or nil, message, code.
function methods:walls() return field.ask(self.object, "__walls", "bake") end

--- A function that tells what light behind bodies has multiplied since now; it returns nil where there is none.
function methods:tally() return light.tally(self.object) end

--- Says what the field does not keep at a degree, once.
function methods:heed(lmax) return light.heed(self.object, lmax) end

return field
