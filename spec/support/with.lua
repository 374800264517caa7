--- A copy of a table, with the fields of another in place of its own: with(defaults, { depth = 3 }).

return function(t, more)
  local out = {}
  for k, v in pairs(t) do out[k] = v end
  for k, v in pairs(more or {}) do out[k] = v end
  return out
end
