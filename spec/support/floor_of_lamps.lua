--- Small spheres along a spiral, `height` above the plane y = 0 up and down by a half, and what they bring to the origin.

--- `at`, `radius` of n spheres, and the irradiance of a surface at the origin that faces +y, for radiance 1.
return function(n, height)
  local at, radius, E = {}, {}, 0
  for i = 1, n do
    local a, r = 2.399963 * i, 3 * math.sqrt(i / n)
    local x, y, z = r * math.cos(a), height + 0.5 * math.sin(i), r * math.sin(a)
    local d2 = x * x + y * y + z * z
    at[i], radius[i] = { x, y, z }, 0.01 + 0.02 * (i % 7) / 6
    E = E + math.pi * radius[i] ^ 2 / d2 * y / math.sqrt(d2)
  end
  return at, radius, E
end
