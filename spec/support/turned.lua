--- Turn i of 20 of a wall: its unit normal, and two axes across it.

return function(i)
  local z, phi = 1 - (2 * i - 1) / 20, i * 2.399963
  local r = math.sqrt(1 - z * z)
  local n = { r * math.cos(phi), r * math.sin(phi), z }
  local least = math.abs(n[1]) < 0.6 and { 1, 0, 0 } or { 0, 1, 0 }
  local u = { n[2] * least[3] - n[3] * least[2], n[3] * least[1] - n[1] * least[3], n[1] * least[2] - n[2] * least[1] }
  local length = math.sqrt(u[1] ^ 2 + u[2] ^ 2 + u[3] ^ 2)
  for a = 1, 3 do u[a] = u[a] / length end
  return n, u, { n[2] * u[3] - n[3] * u[2], n[3] * u[1] - n[1] * u[3], n[1] * u[2] - n[2] * u[1] }
end
