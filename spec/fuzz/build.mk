# Fuzzing: each spec/fuzz/NAME.c feeds bytes to one reader, built with clang, libFuzzer, ASan and
# UBSan from the library's own sources. Seeds are in spec/fuzz/corpus/NAME.tar.gz, and unpacked in
# build/fuzz/corpus/NAME; what a run finds beyond them goes to build/fuzz/found/NAME, crashes to build/fuzz/NAME-*.
#
#   make fuzz                         every reader, FUZZ_RUNS inputs each, or FUZZ_MINUTES where these end first
#   make fuzz FUZZ=obj FUZZ_RUNS=1e5  one of them
#   make fuzz-coverage                lines and branches that seeds and finds reach, per source
#   make fuzz-minimise                put what is worth keeping of seeds and finds into build/fuzz/kept/NAME
#   make fuzz-add FUZZ=obj SEEDS="a.obj build/fuzz/kept/obj/*"   add files to the seeds of a reader

FUZZ_CC   ?= clang
FUZZ_RUNS ?= 1000000
FUZZ      ?= $(filter-out $(if $(WITH_SCENE),,surface transfer) $(if $(WITH_JANSSON),,gltf) $(if $(WITH_JPEG),,jpeg),$(patsubst spec/fuzz/%.c,%,$(wildcard spec/fuzz/*.c)))
FUZZ_DIR  := $(BUILD)/fuzz
FUZZ_MINUTES ?= 10
FUZZ_ARGS ?= -timeout=120 -rss_limit_mb=4096 -print_final_stats=1

# Which sources a target is about, for the coverage; FUZZ_LIBS_NAME and FUZZ_ALSO_NAME (objects of
# its own) may be added.
FUZZ_ABOUT_obj := csrc/geom/obj.c csrc/geom/groups.c csrc/geom/reader.c
FUZZ_ABOUT_mtl := csrc/geom/mtl.c csrc/geom/reader.c
FUZZ_ABOUT_ply := csrc/geom/ply.c csrc/geom/reader.c
FUZZ_ABOUT_npy := csrc/base/array_file.c
FUZZ_ABOUT_exr := csrc/codec/exr.c csrc/codec/exr_read.c
FUZZ_ABOUT_png := csrc/codec/png.c
FUZZ_ABOUT_hdr := csrc/codec/hdr.c
FUZZ_ABOUT_pfm := csrc/codec/pfm.c
FUZZ_ABOUT_jpeg := csrc/codec/jpeg.c
FUZZ_ABOUT_gltf := $(wildcard csrc/codec/gltf/*.c)
FUZZ_ABOUT_merl := csrc/material/merl_file.c csrc/material/merl_table.c
FUZZ_ABOUT_photometry := $(foreach f,file ies ldt write type_b,csrc/light/photometric/$(f).c)
FUZZ_ALSO_photometry := $(patsubst %,$(FUZZ_DIR)/obj/light/photometric/%.o,file ies ldt write type_b table spline pole eval flux sample)
$(FUZZ_DIR)/bin/photometry: $(FUZZ_ALSO_photometry)
FUZZ_ABOUT_tensor := csrc/material/tensor.c csrc/material/rgl_file.c csrc/material/warp.c csrc/material/rgl.c
# Spherical harmonics of irradiance, and errors of lights, are those of the library as it is built.
FUZZ_LIBS_grid := -L$(BUILD)/lib -lylm -Wl,-rpath,$(abspath $(BUILD)/lib)
FUZZ_ABOUT_grid := $(wildcard csrc/grid/file/*.c csrc/grid/small/*.c)
FUZZ_ALSO_grid := $(foreach i,$(ISAS),$(BUILD)/obj/grid/small/mix.$(i).o)
$(FUZZ_DIR)/bin/grid: $(FUZZ_ALSO_grid)

FUZZ_SANITIZE := -fsanitize=address,undefined,fuzzer-no-link -fno-sanitize-recover=undefined
# Loops over numbers that have been read report no comparisons to the fuzzer: these took up to three quarters of a run.
FUZZ_LOOPS := $(foreach d,geom/unwrap image grid grid/small grid/probes surface codec/gltf,$(wildcard csrc/$(d)/*.c))
FUZZ_CFLAGS = -std=gnu11 -DFUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION -O2 -g -fno-omit-frame-pointer $(FUZZ_SANITIZE) -fprofile-instr-generate -fcoverage-mapping \
  -Wno-unknown-pragmas -MMD -MP -Ispec/fuzz/support -I$(INCLUDE)
# Folders whose sources every target may use, and single sources beside them (no kernels: compiling
# the generated ones with sanitizers takes many minutes).
FUZZ_FOLDERS := base image geom grid codec material
FUZZ_MORE    ?=
FUZZ_OBJ := $(patsubst csrc/%.c,$(FUZZ_DIR)/obj/%.o,$(filter-out $(NO_GLTF),$(foreach d,$(FUZZ_FOLDERS),$(call sources,$(d)))) $(FUZZ_MORE))

$(FUZZ_LOOPS:csrc/%.c=$(FUZZ_DIR)/obj/%.o): FUZZ_SANITIZE += -fno-sanitize-coverage=trace-cmp

$(FUZZ_DIR)/obj/codec/%.o: csrc/codec/%.c
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(FUZZ_CC) $(FUZZ_CFLAGS) $(CFLAGS_codec) -c $< -o $@

$(FUZZ_DIR)/obj/%.o: csrc/%.c
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(FUZZ_CC) $(FUZZ_CFLAGS) -c $< -o $@

# A target in one process, of the library as it is built: random mutations, many a second, no sanitizers.
#
#   make fuzz-storm FUZZ_RUNS=1e7     the reader of grids, by seeds of at most STORM_LARGEST bytes
STORM_LARGEST ?= 2000
STORM_SEED    ?= 1
$(FUZZ_DIR)/bin/storm: spec/fuzz/support/storm.c spec/fuzz/grid.c $(OBJ_core)
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(CC) $(CFLAGS) -DFUZZ_LIBRARY spec/fuzz/support/storm.c spec/fuzz/grid.c $(OBJ_core) -lm -o $@

fuzz-storm: $(FUZZ_DIR)/bin/storm $(FUZZ_DIR)/corpus/grid.unpacked   ## damaged grids without sanitizers (FUZZ_RUNS=1000000)
	cd $(FUZZ_DIR) && OMP_NUM_THREADS=1 nice bin/storm $$(printf %.0f $(FUZZ_RUNS)) $(STORM_SEED) $(STORM_LARGEST) corpus/grid/*

# An archive, so that each target takes no more than it needs, with base's kernels, as the library has them. Rooms have files
# of the same name: q keeps each.
FUZZ_KERNELS := $(foreach i,$(ISAS),$(patsubst csrc/%.isa.c,$(BUILD)/obj/%.$(i).o,$(wildcard csrc/base/*.isa.c)))
$(FUZZ_DIR)/libylm.a: $(FUZZ_OBJ) $(FUZZ_KERNELS)
	$(call say,AR,$@)
	$(Q)rm -f $@ && $(AR) qc $@ $^

$(FUZZ_DIR)/bin/%: spec/fuzz/%.c $(FUZZ_DIR)/libylm.a
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(FUZZ_CC) $(FUZZ_CFLAGS) -fsanitize=fuzzer $< $(FUZZ_ALSO_$*) $(FUZZ_DIR)/libylm.a \
	  $(LIBS_codec) $(FUZZ_LIBS_$*) -lm -o $@

# Seeds, one archive per reader: equal seeds make equal bytes.
FUZZ_PACK := LC_ALL=C tar --format=ustar --sort=name --mtime=@0 --owner=0 --group=0 --numeric-owner --mode=644
SEEDS     ?=

$(FUZZ_DIR)/corpus/%.unpacked: spec/fuzz/corpus/%.tar.gz
	@rm -rf $(basename $@) && mkdir -p $(basename $@) && tar -xzf $< -C $(basename $@) && touch $@

FUZZ_SEEDS = $(foreach f,$(FUZZ),$(if $(wildcard spec/fuzz/corpus/$(f).tar.gz),$(FUZZ_DIR)/corpus/$(f).unpacked))

fuzz-add: $(FUZZ_SEEDS)
	@$(if $(SEEDS),,$(error SEEDS names no files))$(if $(word 2,$(FUZZ)),$(error FUZZ names no single reader))mkdir -p $(FUZZ_DIR)/corpus/$(FUZZ)
	@for f in $(SEEDS); do cp $$f $(FUZZ_DIR)/corpus/$(FUZZ)/$$(sha1sum < $$f | cut -d' ' -f1); done
	@cd $(FUZZ_DIR)/corpus/$(FUZZ) && $(FUZZ_PACK) -c * | gzip -9n > $(CURDIR)/spec/fuzz/corpus/$(FUZZ).tar.gz
	@tar -tzf spec/fuzz/corpus/$(FUZZ).tar.gz | wc -l | sed 's/$$/ seeds of $(FUZZ)/'

# A run of a reader; a finding leaves the others to go on, and is counted. NAME.passed has inputs, rate and memory of a run
# without findings, says whether time ended it, and FUZZ_KEEP, a folder, keeps it: a reader that passed there is not run again.
FUZZ_KEEP ?=
fuzz-run-%: $(FUZZ_DIR)/bin/% $(FUZZ_SEEDS)
	@cd $(FUZZ_DIR) && mkdir -p found/$* corpus/$* && rm -f $*.passed; \
	if [ -n "$(FUZZ_KEEP)" ] && cp "$(FUZZ_KEEP)/$*" $*.passed 2>/dev/null; then exit; fi; \
	LLVM_PROFILE_FILE=/dev/null nice bin/$* -runs=$$(printf %.0f $(FUZZ_RUNS)) -max_total_time=$$(awk 'BEGIN { print int(60 * $(FUZZ_MINUTES)) }') \
	  $(FUZZ_ARGS) $(FUZZ_ARGS_$*) -artifact_prefix=$*- found/$* corpus/$* > $*.log 2>&1 && \
	awk -v name=$* -v runs=$(FUZZ_RUNS) '/^stat::/ { n[$$1] = $$2 } END { done = n["stat::number_of_executed_units:"]; \
	  printf "%-12s %9d inputs, %6d a second, %4d MB%s\n", name, done, n["stat::average_exec_per_sec:"], n["stat::peak_rss_mb:"], \
	  done < +runs ? ", ended by time" : "" }' $*.log > $*.passed && \
	{ [ -z "$(FUZZ_KEEP)" ] || cp $*.passed "$(FUZZ_KEEP)/$*"; }; \
	if [ -e $*.passed ]; then cat $*.passed; else echo "== $*"; tail -n 40 $*.log; fi

fuzz: $(FUZZ:%=fuzz-run-%)   ## fuzz the readers under ASan and UBSan (FUZZ=name, FUZZ_RUNS=1000000, FUZZ_MINUTES=10)
	@cd $(FUZZ_DIR) && echo "== all" && cat $(FUZZ:%=%.passed) 2>/dev/null; \
	  awk '/ended by time$$/ { slow = slow (slow ? ", " : "") $$1 " " $$2 " (" $$4 " a second)" } END { \
	  if (slow) printf "ended by %g minutes, with fewer than %.0f inputs: %s\n", $(FUZZ_MINUTES), $(FUZZ_RUNS), slow }' $(FUZZ:%=%.passed) 2>/dev/null; \
	  passed=$$(ls $(FUZZ:%=%.passed) 2>/dev/null | wc -l); failed=$$(($(words $(FUZZ)) - passed)); \
	  echo "$$passed passed, $$failed failed"; [ $$failed = 0 ]

fuzz-coverage: $(foreach f,$(FUZZ),$(FUZZ_DIR)/bin/$(f)) $(FUZZ_SEEDS)   ## what the corpora reach of each reader
	@for f in $(FUZZ); do mkdir -p $(FUZZ_DIR)/found/$$f; \
	  LLVM_PROFILE_FILE=$(FUZZ_DIR)/$$f.profraw $(FUZZ_DIR)/bin/$$f -runs=0 $(FUZZ_DIR)/found/$$f $(FUZZ_DIR)/corpus/$$f >/dev/null 2>&1; \
	  llvm-profdata merge -o $(FUZZ_DIR)/$$f.profdata $(FUZZ_DIR)/$$f.profraw; done
	@$(foreach f,$(FUZZ),echo "== $(f)"; llvm-cov report $(FUZZ_DIR)/bin/$(f) -instr-profile=$(FUZZ_DIR)/$(f).profdata \
	  $(FUZZ_ABOUT_$(f)) | awk '/\.c / || /^TOTAL/ {print $$1, "functions", $$7, "lines", $$10, "branches", $$13}';)

fuzz-minimise: $(foreach f,$(FUZZ),$(FUZZ_DIR)/bin/$(f)) $(FUZZ_SEEDS)
	@for f in $(FUZZ); do mkdir -p $(FUZZ_DIR)/kept; rm -rf $(FUZZ_DIR)/kept/$$f; mkdir $(FUZZ_DIR)/kept/$$f; \
	  LLVM_PROFILE_FILE=/dev/null $(FUZZ_DIR)/bin/$$f -merge=1 $(FUZZ_DIR)/kept/$$f $(FUZZ_DIR)/corpus/$$f $(FUZZ_DIR)/found/$$f >/dev/null 2>&1; \
	  echo "$$f: $$(ls $(FUZZ_DIR)/kept/$$f | wc -l) inputs, $$(du -sb $(FUZZ_DIR)/kept/$$f | cut -f1) bytes in $(FUZZ_DIR)/kept"; done

# `make check` compiles them without clang (see spec/bench/build.mk).
fuzz-check: $(patsubst %.c,$(BUILD)/check/%.o,$(filter-out $(if $(WITH_CODEC),,%/exr.c %/hdr.c %/pfm.c %/png.c %/jpeg.c %/gltf.c) \
  $(if $(call pkg,--cflags,lua5.4),,%/scene.c),$(wildcard spec/fuzz/*.c)))

.PHONY: fuzz-storm fuzz-add fuzz-coverage fuzz-minimise fuzz-check

# The scene sandbox: the bindings and the readers of images instrumented, kernels and all else from libylm as it is built.
FUZZ_ABOUT_scene := csrc/lua/core/sandbox.c csrc/lua/codec/codec.c
# The Lua state outlives each input: leaks are looked for at no single one.
FUZZ_ARGS_scene := -detect_leaks=0
FUZZ_ALSO_scene := $(patsubst csrc/lua/%.c,$(FUZZ_DIR)/lua/%.o,$(wildcard csrc/lua/binding*.c csrc/lua/core/*.c csrc/lua/codec/*.c)) \
  $(patsubst csrc/%.c,$(FUZZ_DIR)/obj/%.o,$(filter-out $(NO_GLTF),$(wildcard csrc/codec/*.c csrc/codec/gltf/*.c)))
FUZZ_LIBS_scene := $(call pkg,--cflags --libs,lua5.4) $(LIBS_codec) -L$(BUILD)/lib -Wl,-rpath,$(abspath $(BUILD))/lib -lylm
$(FUZZ_DIR)/lua/%.o: csrc/lua/%.c
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(FUZZ_CC) $(FUZZ_CFLAGS) $(call pkg,--cflags,lua5.4) -c $< -o $@
$(FUZZ_DIR)/bin/scene: $(FUZZ_ALSO_scene) $(BUILD)/lib/libylm.so
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(FUZZ_CC) $(FUZZ_CFLAGS) -DFUZZ_TREE='"$(CURDIR)"' -fsanitize=fuzzer spec/fuzz/scene.c $(FUZZ_ALSO_scene) $(FUZZ_LIBS_scene) -lm -o $@
$(FUZZ_DIR)/bin/scene: spec/fuzz/scene.c

# Transfers: their reader and elements instrumented, scenes from libylm_scene as it is built.
FUZZ_ABOUT_transfer := csrc/transfer/file.c csrc/transfer/elements.c csrc/transfer/cuts.c
FUZZ_ALSO_transfer := $(patsubst %,$(FUZZ_DIR)/obj/transfer/%.o,closed crossed cuts elements file links sides sum transfer)
FUZZ_LIBS_transfer := -L$(BUILD)/lib -Wl,-rpath,$(abspath $(BUILD))/lib -lylm_scene -lylm
$(FUZZ_DIR)/bin/transfer: spec/fuzz/transfer.c $(FUZZ_ALSO_transfer) $(LIBS)
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(FUZZ_CC) $(FUZZ_CFLAGS) -fsanitize=fuzzer spec/fuzz/transfer.c $(FUZZ_ALSO_transfer) $(FUZZ_LIBS_transfer) -lm -o $@

# Light on surfaces: its reader, charts and look-ups instrumented, scenes from libylm_scene as it is built.
FUZZ_ABOUT_surface := csrc/surface/file.c csrc/surface/look.c
FUZZ_ALSO_surface := $(patsubst %,$(FUZZ_DIR)/obj/surface/%.o,charts file look)
FUZZ_LIBS_surface := $(FUZZ_LIBS_transfer)
$(FUZZ_DIR)/bin/surface: spec/fuzz/surface.c $(FUZZ_ALSO_surface) $(LIBS)
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(FUZZ_CC) $(FUZZ_CFLAGS) -fsanitize=fuzzer spec/fuzz/surface.c $(FUZZ_ALSO_surface) $(FUZZ_LIBS_surface) -lm -o $@

# Charts of meshes: instrumented, all else from libylm as it is built.
FUZZ_ABOUT_unwrap := $(wildcard csrc/geom/unwrap/*.c)
FUZZ_ALSO_unwrap := $(patsubst csrc/%.c,$(FUZZ_DIR)/obj/%.o,$(FUZZ_ABOUT_unwrap))
FUZZ_LIBS_unwrap := -L$(BUILD)/lib -Wl,-rpath,$(abspath $(BUILD))/lib -lylm
$(FUZZ_DIR)/bin/unwrap: spec/fuzz/unwrap.c $(FUZZ_ALSO_unwrap) $(BUILD)/lib/libylm.so
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(FUZZ_CC) $(FUZZ_CFLAGS) -fsanitize=fuzzer spec/fuzz/unwrap.c $(FUZZ_ALSO_unwrap) $(FUZZ_LIBS_unwrap) -lm -o $@

# Probes of engines: their reader and look-up instrumented.
FUZZ_ABOUT_probes := csrc/grid/probes/file.c csrc/grid/probes/look.c csrc/grid/probes/names.c
FUZZ_ALSO_probes := $(patsubst %,$(FUZZ_DIR)/obj/grid/%.o,probes/file probes/look probes/names lattice)
FUZZ_LIBS_probes := -L$(BUILD)/lib -Wl,-rpath,$(abspath $(BUILD))/lib -lylm
$(FUZZ_DIR)/bin/probes: spec/fuzz/probes.c $(FUZZ_ALSO_probes) $(BUILD)/lib/libylm.so
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(FUZZ_CC) $(FUZZ_CFLAGS) -fsanitize=fuzzer spec/fuzz/probes.c $(FUZZ_ALSO_probes) $(FUZZ_LIBS_probes) -lm -o $@
