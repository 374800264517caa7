# Benchmarks: each spec/bench/NAME.c is a program over the libraries; bench.h has the timing.
# scaling.lua plots how times grow, by VTK.

BENCHES := $(patsubst spec/bench/%.c,$(BUILD)/bench/%,$(filter-out $(if $(WITH_SCENE),,%/transfer.c),$(wildcard spec/bench/*.c)))
PEER    ?=
BENCH   ?=
# BENCH=quick: all, briefly; BENCH="light sh": these. many_lights and accuracy take minutes and are run by name.
benches := $(filter-out quick,$(BENCH))
BENCH_LIBS_transfer := -lylm_scene -lembree3

$(BUILD)/bench/%: spec/bench/%.c $(wildcard spec/bench/*.h) $(LIBS)
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(CC) $(CFLAGS) $< -L$(BUILD)/lib $(BENCH_LIBS_$*) -lylm -lm \
	  -Wl,-rpath,'$$ORIGIN/../lib' -o $@

# `make all` leaves benches alone: `make check` compiles them, optimised, since some warnings need that.
$(BUILD)/check/%.o: %.c
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(CC) $(CFLAGS) $(CFLAGS_check) -Werror -c $< -o $@
$(BUILD)/check/spec/fuzz/%.o: CFLAGS_check = -Ispec/fuzz/support $(call pkg,--cflags,lua5.4)
bench-check: $(patsubst $(BUILD)/bench/%,$(BUILD)/check/spec/bench/%.o,$(BENCHES))
.PHONY: bench-check

bench: $(BENCHES) all   ## measure: peaks of this machine, then kernels, grids, rays, plots into out/bench (PEER=prefix compares; BENCH=quick or names)
	@for b in $(filter %/peak,$(BENCHES)) $(filter-out %/peak,$(BENCHES)); do \
	  case " $(or $(benches),$(filter-out many_lights accuracy,$(notdir $(BENCHES)))) " in *" $${b##*/} "*) BENCH=$(filter quick,$(BENCH)) PEER=$(PEER) $$b || exit 1; echo;; esac; done
	@case " $(or $(benches),calls) " in *" calls "*) for l in luajit lua5.4; do if command -v $$l >/dev/null; then \
	  YLM_LUA=$$l $(BUILD)/ylm run spec/bench/calls.lua || exit 1; fi; done;; esac
	@case " $(or $(benches),scaling) " in *" scaling "*) BENCH=$(filter quick,$(BENCH)) $(BUILD)/ylm run spec/bench/scaling.lua $(OUT)/bench;; esac

# spec/bench/vulkan_*.lua run over every device that Vulkan offers.
BENCH_LUA ?= $(lastword $(LUAS))
bench-vulkan: all   ## measure every Vulkan device: ns per pair beside its peaks and the paper's milliseconds
	@for b in $(sort $(wildcard spec/bench/vulkan*.lua)); do LUA_PATH='lua/?.lua;lua/?/init.lua;./?.lua;;' \
	  LUA_CPATH='$(BUILD)/$(patsubst luajit,lua5.1,$(BENCH_LUA))/?.so;;' $(BENCH_LUA) $$b || exit 1; done
.PHONY: bench-vulkan
