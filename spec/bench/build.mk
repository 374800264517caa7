# Benchmarks: each spec/bench/NAME.c is a program over the libraries; bench.h has the timing.
# scaling.lua plots how times grow, by VTK.

BENCHES := $(patsubst spec/bench/%.c,$(BUILD)/bench/%,$(filter-out $(if $(WITH_SCENE),,%/transfer.c %/trace.c %/path.c %/green.c %/choose.c %/links.c %/gather.c %/glossy.c %/emit.c),$(wildcard spec/bench/*.c)))
PEER    ?=
BENCH   ?=
# BENCH=quick: all, briefly; BENCH="light sh": these. many_lights, many_virtual, accuracy and choose take minutes and are run by name.
benches := $(filter-out quick,$(BENCH))
BENCH_LIBS_transfer := -lylm_scene $(LIBS_scene)
BENCH_CFLAGS_transfer := $(CFLAGS_scene)
BENCH_LIBS_trace    := -lylm_scene
BENCH_LIBS_green    := -lylm_scene
BENCH_LIBS_links    := -lylm_scene
BENCH_LIBS_gather   := -lylm_scene
BENCH_LIBS_glossy   := -lylm_scene
BENCH_LIBS_emit     := -lylm_scene
BENCH_LIBS_path     := -lylm_scene -ldl
BENCH_LIBS_choose   := -lylm_scene
BENCH_LIBS_products := -lylm_rival

$(BUILD)/bench/%: spec/bench/%.c $(wildcard spec/bench/*.h) $(LIBS)
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(CC) $(CFLAGS) $(BENCH_CFLAGS_$*) $< -L$(BUILD)/lib $(BENCH_LIBS_$*) -lylm -lm \
	  -Wl,-rpath,'$$ORIGIN/../lib' -o $@

# `make all` leaves benches alone: `make check` compiles them, optimised, since some warnings need that.
$(BUILD)/check/%.o: %.c
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(CC) $(CFLAGS) $(CFLAGS_check) -Werror -c $< -o $@
$(BUILD)/check/spec/bench/transfer.o: CFLAGS_check = $(CFLAGS_scene)
$(BUILD)/check/spec/fuzz/%.o: CFLAGS_check = -Ispec/fuzz/support $(call pkg,--cflags,lua5.4)
bench-check: $(patsubst $(BUILD)/bench/%,$(BUILD)/check/spec/bench/%.o,$(BENCHES))
.PHONY: bench-check

# Tables go into BENCH_DOCS/NAME.md, from which docs/performance.md is written; BENCH_DOCS= writes none, and so does BENCH=quick.
BENCH_DOCS  ?= docs/bench
bench_keep   = BENCH_DOCS='$(if $(filter quick,$(BENCH)),,$(BENCH_DOCS))' CC='$(CC)'
# Benches in Lua that are run by name: make bench BENCH="moving memory".
BENCHES_LUA := $(filter-out calls scaling lamps vulkan_%,$(patsubst spec/bench/%.lua,%,$(wildcard spec/bench/*.lua)))

bench: $(BENCHES) all   ## measure: peaks of this machine, kernels, grids, rays: tables into docs/bench, plots into out/bench (PEER=prefix compares; BENCH=quick or names)
	@for b in $(filter %/peak,$(BENCHES)) $(filter-out %/peak,$(BENCHES)); do \
	  case " $(or $(benches),$(filter-out many_lights many_virtual accuracy choose,$(notdir $(BENCHES)))) " in *" $${b##*/} "*) \
	    $(bench_keep) BENCH_SAYS="make bench BENCH=$${b##*/}$(if $(PEER), PEER=prefix)" BENCH=$(filter quick,$(BENCH)) PEER=$(PEER) \
	    spec/bench/record $${b##*/} $$b || exit 1; echo;; esac; done
	@for b in $(filter $(BENCHES_LUA),$(benches)); do \
	  $(bench_keep) BENCH_SAYS="make bench BENCH=$$b" spec/bench/record $$b $(BUILD)/ylm run spec/bench/$$b.lua || exit 1; done
	@case " $(or $(benches),calls) " in *" calls "*) for l in luajit lua5.4; do if command -v $$l >/dev/null; then \
	  $(bench_keep) BENCH_SAYS="make bench BENCH=calls" YLM_LUA=$$l spec/bench/record calls_$$l $(BUILD)/ylm run spec/bench/calls.lua \
	  || exit 1; fi; done;; esac
	@case " $(or $(benches),scaling) " in *" scaling "*) BENCH=$(filter quick,$(BENCH)) $(BUILD)/ylm run spec/bench/scaling.lua $(OUT)/bench;; esac

# spec/bench/vulkan_*.lua run over every device that Vulkan offers.
BENCH_LUA ?= $(lastword $(LUAS))
bench-vulkan: all   ## measure every Vulkan device: ns per pair beside its peaks and the paper's milliseconds
	@for b in $(sort $(wildcard spec/bench/vulkan*.lua)); do n=$${b##*/}; $(bench_keep) BENCH_SAYS="make bench-vulkan" \
	  LUA_PATH='lua/?.lua;lua/?/init.lua;./?.lua;;' LUA_CPATH='$(BUILD)/$(patsubst luajit,lua5.1,$(BENCH_LUA))/?.so;;' \
	  spec/bench/record $${n%.lua} $(BENCH_LUA) $$b || exit 1; done
.PHONY: bench-vulkan
