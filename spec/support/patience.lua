--- Seconds that a spec waits for what takes far fewer, here: YLM_SPEC_PATIENCE times as many, for checkers that slow all down
-- and for busy processors (make check-long: 10).

return function(seconds) return math.ceil(seconds * (tonumber(os.getenv "YLM_SPEC_PATIENCE") or 1)) end
