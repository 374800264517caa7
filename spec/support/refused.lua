--- Refusals for spec/support/refusals: a call and what its message must match, and again.

return function(...)
  local out = {}
  for i = 1, select("#", ...), 2 do
    out[#out + 1] = { call = select(i, ...), says = (select(i + 1, ...)) }
  end
  return out
end
