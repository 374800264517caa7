# Benchmarks: each spec/bench/NAME.c is a program over the libraries; bench.h has the timing.

BENCHES := $(patsubst spec/bench/%.c,$(BUILD)/bench/%,$(wildcard spec/bench/*.c))
PEER    ?=

$(BUILD)/bench/%: spec/bench/%.c $(BUILD)/lib/libylm.so
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(CC) $(CFLAGS) $< -L$(BUILD)/lib $(BENCH_LIBS_$*) -lylm -lm \
	  -Wl,-rpath,'$$ORIGIN/../lib' -o $@

bench: all $(BENCHES)   ## measure: peaks of this machine, then ns per point and per pair (PEER=prefix compares)
	@for b in $(filter %/peak,$(BENCHES)) $(filter-out %/peak,$(BENCHES)); do PEER=$(PEER) $$b || exit 1; echo; done
	@for l in luajit lua5.4; do if command -v $$l >/dev/null; then \
	  YLM_LUA=$$l $(BUILD)/ylm run spec/bench/calls.lua || exit 1; fi; done
