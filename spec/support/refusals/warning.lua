--- Refusals of ylm.on_warning.
return {
  on_warning = {
    { call = function(ylm) ylm.on_warning "stderr" end, says = "a function, false or nothing expected, got 'stderr'" },
    { call = function(ylm) ylm.on_warning(true) end, says = "got true" },
  },
}
