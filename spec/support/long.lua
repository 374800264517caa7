--- A number for `make test`, and the larger one of `make check-long` (YLM_SPEC=long): for k = 1, long(100, 1000) do ... end.

return function(short, long) return os.getenv "YLM_SPEC" == "long" and long or short end
