# ylm - spherical-harmonic lighting for Lua. `make help` lists the targets.

SHELL   := /bin/bash
BUILD   ?= build
OUT     ?= out
PREFIX  ?= /usr/local
CC      ?= cc
CXX     ?= c++
AR      ?= ar
# -g1: debuggers see lines and calls; OPT='-O0 -g' shows variables too
OPT     ?= -O3 -g1
WARN    := -Wall -Wextra -Wshadow -Wpointer-arith -Wvla
CWARN   := $(WARN) -Wstrict-prototypes -Wmissing-prototypes
SANITIZE ?=
V       ?=
Q       := $(if $(V),,@)
say      = @printf '  %-4s %s\n' $(1) $(2)
VERSION   := $(shell sed -n 's/^#define YLM_VERSION "\(.*\)"/\1/p' csrc/base/ylm_base.h)
SOVERSION := $(firstword $(subst ., ,$(VERSION)))
# Luas whose interpreter and headers are both there; `luarocks make` names one by ROCK_LUA.
LUAS    ?= $(if $(ROCK_LUA),$(shell $(ROCK_LUA) -e 'print("lua" .. _VERSION:match("%d.%d"))'),$(foreach l,\
             lua5.1 luajit lua5.2 lua5.3 lua5.4 lua5.5,$(if $(shell command -v $(l) >/dev/null && pkg-config --exists $(l) 2>/dev/null && echo y),$(l))))
# The system is asked once, not wherever the name stands: so below.
LUAS    := $(LUAS)
LUA_CFLAGS ?= # of the one Lua to build for; pkg-config knows them otherwise
ABIS    := $(sort $(patsubst luajit,lua5.1,$(LUAS)))

# All processors work, unless -j says how many, or several goals stand in an order (make clean all).
ifeq ($(word 2,$(MAKECMDGOALS)),)
MAKEFLAGS += $(shell case "$$MAKEFLAGS" in (*-j*) ;; (*) echo -j$$(nproc) ;; esac)
endif

# -- what belongs to which library: the ladder in csrc/README.md, core < codec < scene < { tops } < lua -----------

LADDER  := $(shell sed -n '/^    base </{N; s/\n//; s/ *< */./g; s/\.codec\./ codec /; s/\.{/ /; s/}.*//; s/|//g; p}' csrc/README.md)
$(if $(word 4,$(LADDER)),,$(error csrc/README.md has no ladder "    base < .. < codec < .. < { .. } < lua"))
CORE    := $(subst ., ,$(word 1,$(LADDER)))
CODEC   := $(word 2,$(LADDER))
SCENE   := $(subst ., ,$(word 3,$(LADDER)))
TOPS    := $(strip $(wordlist 4,$(words $(LADDER)),$(LADDER)))

ARCH    := $(shell $(CC) -dumpmachine 2>/dev/null | cut -d- -f1)
ALL_ISAS := $(if $(filter x86_64,$(ARCH)),sse2 avx2 avx512,$(if $(filter aarch64,$(ARCH)),neon))
# Those that are compiled: all, or KERNELS="sse2 avx2".
KERNELS ?= $(ALL_ISAS)
ISAS    := $(or $(filter $(KERNELS),$(ALL_ISAS)),$(ALL_ISAS))
FLAGS_sse2   := -msse2 -DYLM_VECTOR_BYTES=16
FLAGS_neon   := -DYLM_VECTOR_BYTES=16
FLAGS_avx2   := -mavx2 -mfma -DYLM_VECTOR_BYTES=32
FLAGS_avx512 := -mavx512f -mavx512dq -mavx512vl -mavx512bw -mavx2 -mfma -mprefer-vector-width=512 -DYLM_VECTOR_BYTES=64

# Debuggers see lines of kernels, not their thousands of values, whatever OPT says. Passes that look for repetitions are left out of LEAN files,
# and of STRAIGHT ones, where loops are written out, those that look for loops too (gcc; either compiles faster, not slower code).
LEAN     := -fno-tree-pre -fno-code-hoisting -fno-gcse -fno-tree-vrp
LEAN     := $(if $(filter -O3,$(OPT)),$(shell $(CC) $(LEAN) -Werror -E -x c /dev/null >/dev/null 2>&1 && echo $(LEAN)))
STRAIGHT := $(if $(LEAN),-O2 $(LEAN))
LEAN_FILES     := $(wildcard csrc/sh/product/*.isa.c csrc/light/flat/kernel.isa.c)
STRAIGHT_FILES := $(wildcard csrc/*/*/gen/*.isa.c csrc/sh/eval/low_*.isa.c csrc/light/moments/any_*.isa.c)
KERNEL_OPT = $(if $(filter -g,$(OPT)),-g1) $(if $(filter $(LEAN_FILES),$(1)),$(LEAN)) $(if $(filter $(STRAIGHT_FILES),$(1)),$(STRAIGHT)) \
             $(if $(findstring /gen/,$(1)),$(SANITIZE_gen))

# Links to the public headers, which alone are on the include path; made anew where their list or its place has changed.
INCLUDE := $(BUILD)/include
BUILT_SETS := $(INCLUDE)/ylm_built_sets.h
PUBLIC  := $(wildcard csrc/*/ylm_*.h)
link_headers = rm -rf $(INCLUDE) && mkdir -p $(INCLUDE) && ln -s $(realpath $(PUBLIC)) $(INCLUDE)
# One header says which kernels this build has. Goals that only call make again leave all as it is.
BUILT := $(shell sed -n '1s|^/\* \(.*\) \*/$$|\1|p' $(BUILT_SETS) 2>/dev/null)
OWN_WORK := $(if $(MAKECMDGOALS),$(filter-out clean help deps demo test,$(MAKECMDGOALS)),all)
ifneq ($(OWN_WORK),)
ifneq ($(sort $(realpath $(filter-out $(BUILT_SETS),$(wildcard $(INCLUDE)/*)))),$(sort $(realpath $(PUBLIC))))
$(shell $(link_headers))
BUILT :=
endif
ifneq ($(BUILT),$(ISAS))
$(shell printf '/* %s */\n#define YLM_SETS_WITH(F, ...) %s\n' '$(ISAS)' '$(foreach i,$(ISAS),F($(i), __VA_ARGS__))' >$(BUILT_SETS))
endif
endif

CFLAGS  := -std=gnu11 -fPIC -fvisibility=hidden -fopenmp -fno-math-errno -fno-trapping-math -MMD -MP \
           $(OPT) $(CWARN) $(SANITIZE) -I$(INCLUDE)
LDFLAGS := -shared -fopenmp $(SANITIZE) -Wl,-z,now -Wl,-z,nodelete $(if $(SANITIZE),,-Wl,-z,defs)

pkg      = $(shell pkg-config $(1) $(2) 2>/dev/null)
# zlib comes with libpng; without its header pages are larger.
ZLIB        := $(call pkg,--libs,zlib)
# glTF is read where jansson is, JPEG where libjpeg is.
WITH_JANSSON ?= $(if $(call pkg,--libs,jansson),y)
WITH_JANSSON := $(WITH_JANSSON)
WITH_JPEG    ?= $(if $(call pkg,--libs,libjpeg),y)
WITH_JPEG    := $(WITH_JPEG)
CFLAGS_codec := $(call pkg,--cflags,OpenEXR libpng $(if $(WITH_JANSSON),jansson) $(if $(WITH_JPEG),libjpeg)) $(if $(WITH_JPEG),-DYLM_JPEG) $(if $(ZLIB),$(call pkg,--cflags,zlib) -DYLM_ZLIB)
# OpenEXRCore has its version behind its name: -lOpenEXRCore-3_1, and OpenEXR 2 has none.
OPENEXR     := $(filter -L% -lOpenEXRCore%,$(call pkg,--libs,OpenEXR))
LIBS_codec  := $(OPENEXR) $(call pkg,--libs,libpng $(if $(WITH_JANSSON),jansson) $(if $(WITH_JPEG),libjpeg)) $(ZLIB)
LIBS_scene   = $(EMBREE_DIR:%=-L%/lib) $(EMBREE_DIR:%=-Wl,-rpath,%/lib) -lembree$(EMBREE) -ldl
CFLAGS_scene = -DYLM_EMBREE=$(EMBREE) $(EMBREE_DIR:%=-isystem %/include)

# -- objects: *.c of a folder and its rooms once, *.isa.c once per instruction set, *.real.c and *.real.isa.c for float and
# for double too -----------------------------------------------------------------------------

sources = $(filter-out %.isa.c %.real.c,$(wildcard csrc/$(1)/*.c csrc/$(1)/*/*.c csrc/$(1)/*/*/*.c csrc/$(1)/*/*/gen/*.c))
kernels = $(wildcard csrc/$(1)/*.isa.c csrc/$(1)/*/*.isa.c csrc/$(1)/*/*/*.isa.c csrc/$(1)/*/*/gen/*.isa.c)
reals   = $(wildcard csrc/$(1)/*.real.c csrc/$(1)/*/*.real.c csrc/$(1)/*/*/*.real.c)
typed   = $(foreach t,float double,$(patsubst %.real,%.$(t),$(filter %.real,$(1)))) $(filter-out %.real,$(1))
objects = $(patsubst csrc/%.c,$(BUILD)/obj/%.o,$(call sources,$(1))) \
          $(patsubst csrc/%,$(BUILD)/obj/%.o,$(call typed,$(patsubst %.c,%,$(call reals,$(1))))) \
          $(foreach i,$(ISAS),$(patsubst csrc/%,$(BUILD)/obj/%.$(i).o,$(call typed,$(patsubst %.isa.c,%,$(call kernels,$(1))))))

# Embree 3 or 4, whichever is there, the former if both are; EMBREE=4 wants the other, EMBREE_DIR=prefix one elsewhere.
EMBREE_DIR ?=
EMBREE     ?= $(firstword $(foreach v,3 4,$(if $(wildcard $(addsuffix /include/embree$(v)/rtcore.h,$(EMBREE_DIR) /usr /usr/local)),$(v))))

# Built where OpenEXR and libpng are, and where Embree is; spherical harmonics alone need none of them.
WITH_CODEC  ?= $(and $(filter -l%,$(OPENEXR)),$(call pkg,--libs,libpng),y)
WITH_CODEC  := $(WITH_CODEC)
WITH_EMBREE ?= $(EMBREE)
WITH_SCENE  ?= $(WITH_EMBREE)

OBJ_core  := $(foreach d,$(CORE),$(call objects,$(d)))
# Files of the glTF reader that this build has not: missing.c, or all others.
NO_GLTF   := $(if $(WITH_JANSSON),csrc/codec/gltf/missing.c,$(filter-out %/missing.c,$(wildcard csrc/codec/gltf/*.c)))
OBJ_codec := $(filter-out $(patsubst csrc/%.c,$(BUILD)/obj/%.o,$(NO_GLTF)),$(foreach d,$(CODEC),$(call objects,$(d))))
OBJ_scene := $(filter-out $(patsubst %,$(BUILD)/obj/trace/embree%.o,$(filter-out $(EMBREE),3 4)),$(foreach d,$(SCENE),$(call objects,$(d))))

PARTS := $(if $(WITH_CODEC),codec) $(if $(WITH_SCENE),scene)
LIBS := $(BUILD)/lib/libylm.so $(foreach p,$(PARTS),$(BUILD)/lib/libylm_$(p).so)
HAVE := core $(PARTS)
# Parts with rules of their own.
-include csrc/vtk/build.mk csrc/vulkan/build.mk csrc/rival/build.mk csrc/mpi/build.mk lua/ylm/codegen/build.mk spec/bench/build.mk spec/fuzz/build.mk lua/ylm/doc/build.mk
-include package/build.mk

# Code that only hands on, bindings and calls of VTK, is as fast so and compiles in half the time.
HAND_ON := $(if $(filter -O3,$(OPT)),-O1 -ftree-vectorize)

BINDINGS := $(foreach a,$(ABIS),$(foreach m,$(HAVE),$(BUILD)/$(a)/ylm/c/$(m).so))

.PHONY: all deps demo test spec quick bench gen gen-check check check-long portable asan fuzz docs format install rock clean help
.DEFAULT_GOAL := all

# What is not found is left out, and named at the end of make.
NEEDS_codec  := image files, which need OpenEXR 3 and libpng (libopenexr-dev libpng-dev)
NEEDS_scene  := scenes and rays, which need Embree 3 or 4 (libembree-dev)
NEEDS_vtk    := pictures of the mathematics, which need VTK 9 (libvtk9-dev libegl-dev libglew-dev libopengl-dev libx11-dev)
NEEDS_vulkan := work on graphics processors, which needs Vulkan's headers and glslc (libvulkan-dev glslc)
NEEDS_mpi    := work that many processes share, which needs MPI (libopenmpi-dev openmpi-bin)
NEEDS_lua    := the Lua module, which needs a Lua and its headers (lua5.4 liblua5.4-dev)
LEFT_OUT     := $(filter-out $(HAVE),codec scene vtk vulkan mpi) $(if $(LUAS),,lua)

all: $(LIBS) $(BINDINGS) $(BUILD)/ylm   ## build the libraries, a binding for each Lua found, and build/ylm
	$(if $(strip $(LEFT_OUT)),@$(foreach p,$(LEFT_OUT),echo "left out: $(NEEDS_$(p))";))

define KERNEL
$(BUILD)/obj/%.$(1).o: csrc/%.isa.c
	@mkdir -p $$(@D)
	$$(call say,CC,$$@)
	$(Q)$$(CC) $$(CFLAGS) $$(FLAGS_$(1)) $$(call KERNEL_OPT,$$<) -DYLM_ISA=$(1) -c $$< -o $$@
endef
$(foreach i,$(ISAS),$(eval $(call KERNEL,$(i))))

# Files that are compiled for each element type: real is float, then double.
REAL_float  := -DYLM_REAL_IS_FLOAT
REAL_double :=
define REAL
$(BUILD)/obj/%.$(1).o: csrc/%.real.c
	@mkdir -p $$(@D)
	$$(call say,CC,$$@)
	$(Q)$$(CC) $$(CFLAGS) $(REAL_$(1)) -c $$< -o $$@
endef
$(foreach t,float double,$(eval $(call REAL,$(t))))

define REAL_KERNEL
$(BUILD)/obj/%.$(1).$(2).o: csrc/%.real.isa.c
	@mkdir -p $$(@D)
	$$(call say,CC,$$@)
	$(Q)$$(CC) $$(CFLAGS) $$(FLAGS_$(2)) $$(call KERNEL_OPT,$$<) $(REAL_$(1)) -DYLM_ISA=$(2) -c $$< -o $$@
endef
$(foreach i,$(ISAS),$(foreach t,float double,$(eval $(call REAL_KERNEL,$(t),$(i)))))

$(BUILD)/obj/codec/%.o: csrc/codec/%.c
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(CC) $(CFLAGS) $(CFLAGS_codec) -c $< -o $@

# Says for which Embree objects were made; made anew where it is for the other.
EMBREE_IS := $(BUILD)/obj/trace/embree
$(if $(WITH_SCENE),$(if $(filter $(EMBREE)$(EMBREE_DIR),$(shell cat $(EMBREE_IS) 2>/dev/null)),,$(eval .PHONY: $(EMBREE_IS))))
$(EMBREE_IS):
	@mkdir -p $(@D) && echo $(EMBREE)$(EMBREE_DIR) > $@
$(BUILD)/obj/trace/%.o: csrc/trace/%.c $(EMBREE_IS)
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(CC) $(CFLAGS) $(CFLAGS_scene) -c $< -o $@

# Files of few bytes are decoded to the same bits on every machine: products and sums are not contracted.
$(BUILD)/obj/grid/small/%.o: CFLAGS += -ffp-contract=off
# Surfaces at places, and weights of few lamps there, have the same bits by all kernels and one by one.
$(addprefix $(BUILD)/obj/scene/,scene.o patch.o sphere.o weights.o surface.%.o ahead.%.o): CFLAGS += -ffp-contract=off
# Files that hand on to devices, pages, processes and other files' readers.
$(BUILD)/obj/vulkan/%.o $(BUILD)/obj/figure/%.o $(BUILD)/obj/codec/gltf/%.o $(BUILD)/obj/mpi/%.o: CFLAGS += $(HAND_ON)
$(BUILD)/obj/%.o: csrc/%.c
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(CC) $(CFLAGS) -c $< -o $@

# Programs ask for libylm.so.0, which is a link here; `make install` adds the version.
SONAME = -Wl,-soname,$(@F).$(SOVERSION)
LINKED = && ln -sf $(@F) $@.$(SOVERSION)

$(BUILD)/lib/libylm.so: $(OBJ_core) Makefile
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(CC) $(LDFLAGS) $(SONAME) $(OBJ_core) -lm -o $@ $(LINKED)

define PART
$(BUILD)/lib/libylm_$(1).so: $(OBJ_$(1)) $(BUILD)/lib/libylm.so Makefile
	@mkdir -p $$(@D)
	$$(call say,LINK,$$@)
	$(Q)$$(CC) $$(LDFLAGS) $$(SONAME) -Wl,-rpath,'$$$$ORIGIN' $(OBJ_$(1)) -L$(BUILD)/lib -lylm $(LIBS_$(1)) -lm -o $$@ $$(LINKED)
endef
$(foreach p,codec scene,$(eval $(call PART,$(p))))

# A binding is compiled per Lua ABI and finds the libraries by $ORIGIN.
LIBS_OF_core   := -lylm
LIBS_OF_codec  := -lylm_codec -lylm
LIBS_OF_scene  := -lylm_scene -lylm
LIBS_OF_vtk    := -lylm_vtk -lylm
LIBS_OF_vulkan := -lylm_vulkan -lylm
LIBS_OF_rival  := -lylm_rival -lylm
LIBS_OF_mpi    := -lylm_mpi -lylm

# Strings of Lua 5.5 call csrc/lua/core/sandbox.c after Lua has closed its libraries: bindings stay loaded.
define BINDING
CFLAGS_$(1) := $(or $(strip $(LUA_CFLAGS)),$(call pkg,--cflags,$(1)))
$(BUILD)/$(1)/obj/%.o: csrc/lua/%.c
	@mkdir -p $$(@D)
	$$(call say,CC,$$@)
	$(Q)$$(CC) $$(CFLAGS) $$(HAND_ON) $$(CFLAGS_$(1)) -c $$< -o $$@
$(foreach m,$(HAVE),
$(BUILD)/$(1)/ylm/c/$(m).so: $(patsubst csrc/lua/%.c,$(BUILD)/$(1)/obj/%.o,$(wildcard csrc/lua/binding*.c csrc/lua/$(m)/*.c)) $(LIBS) Makefile
	@mkdir -p $$(@D)
	$$(call say,LINK,$$@)
	$(Q)$$(CC) -shared -fopenmp $(SANITIZE) -Wl,-z,nodelete $$(filter %.o,$$^) -L$(BUILD)/lib $(LIBS_OF_$(m)) -Wl,-rpath,'$$$$ORIGIN:$$$$ORIGIN/../../../lib:$$$$ORIGIN/../../../..' -lm -o $$@
)
endef
$(foreach a,$(ABIS),$(eval $(call BINDING,$(a))))

$(BUILD)/ylm: lua/ylm/cli/ylm.in Makefile
	@mkdir -p $(@D)
	$(Q)sed -e 's|@ROOT@|$(CURDIR)|; s|@LUA@|$(CURDIR)/lua|g; s|@C@|$(abspath $(BUILD))/lua$$v|' $< > $@ && chmod +x $@

# -- what a newcomer says -----------------------------------------------------------

# Packages may have brought the compiler and the Luas that this reading of the file did not find:
# work goes on in a second one, with this one's processors (+).
again = +@$(MAKE) --no-print-directory $(if $(filter -j%,$(MAKEFLAGS)),,-j$(shell nproc)) $(1)

deps:   ## install what is missing (Debian packages; says what first; DEPS=no skips)
	@.ci/deps build demo test

demo:   ## install, build, render the picture of the README into out/
	@.ci/deps build demo
	$(call again,all)
	@$(BUILD)/ylm run examples/01_floor_lights.lua $(ARGS)

# A processor tests its widest kernels. Beside AVX-512, those of 32 bytes are tested but for sums of lights (spec/narrow_spec.lua);
# those of 16 bytes for the basis, as NEON (spec/neon_spec.lua). A build that has all keeps all, as check-long does.
CPU_FLAGS    = $(shell sed -n '/^flags/{s/.*: //p;q}' /proc/cpuinfo 2>/dev/null)
CPU_sse2    := sse2
CPU_avx2    := avx2 fma
CPU_avx512  := avx512f avx512dq avx512vl avx512bw
RUN_HERE     = $(foreach i,$(ALL_ISAS),$(if $(and $(CPU_FLAGS),$(filter-out $(CPU_FLAGS),$(CPU_$(i)))),,$(i)))
TESTED       = $(if $(and $(filter-out $(BUILT),$(ALL_ISAS)),$(CPU_FLAGS)),$(lastword $(RUN_HERE)),$(ALL_ISAS))
NOT_TESTED   = $(filter-out $(filter $(TESTED),$(RUN_HERE)),$(ALL_ISAS))
NARROWER     = $(if $(filter avx2,$(TESTED)),,$(if $(filter avx512,$(TESTED)), (spec/narrow_spec.lua runs those of avx2 that sum no lights)))
WHY_NOT      = no spec runs kernels for $(NOT_TESTED)$(NARROWER): $(if $(filter-out $(TESTED),$(NOT_TESTED)),specs run the widest that this processor has; make builds all,this processor has none)

test:   ## install, build, run every check; the last line counts them
	@.ci/deps build demo test
	$(if $(NOT_TESTED),@echo '$(WHY_NOT)')
	$(call again,all KERNELS='$(strip $(TESTED))')
	@BUILD=$(abspath $(BUILD)) spec/run $(SPEC)

# -- checks ------------------------------------------------------------------------

spec: all   ## run the specs, without installing what they need (SPEC=files for some of them, SPEC_LUAS=lua5.4 for a Lua)
	@BUILD=$(abspath $(BUILD)) spec/run $(SPEC)

# Under one Lua, without devices, cross-compiling, installing, and the papers' scripts.
quick: all   ## the specs that a change of one file needs: 90 seconds on two cores
	@YLM_SPEC=quick BUILD=$(abspath $(BUILD)) SPEC_LUAS='$(or $(SPEC_LUAS),lua5.4)' spec/run $(SPEC)

check-long: all   ## run by hand before a release, hours (LONG=parts): sanitizers, fuzzers, kills, clang, Lua 5.5, Embree 4, minimal Debians
	@BUILD=$(abspath $(BUILD)) spec/long $(LONG)

portable: ## build and test in minimal roots of Debian 12 and 13, by debootstrap as root (SUITES=trixie, PORTABLE_MORE=packages)
	@BUILD=$(abspath $(BUILD)) spec/portable $(SUITES) $(SPEC)

check: gen-check bench-check fuzz-check   ## style, architecture (spec/check), generated files, warnings of benches and fuzz targets, without running specs
	luacheck -q examples lua rockspec spec
	@LUA_PATH='./?.lua' $(CODEGEN_LUA) spec/check/main.lua
	@if command -v clang-format >/dev/null; then clang-format --dry-run --Werror $(FORMATTED); \
	else echo "clang-format is not installed"; fi

# The sanitizers' runtime has to come first in a process that was not built with it. Leaks are not
# looked for: drivers keep what they have until the end. Checks are calls, not inlined, and generated
# straight-line kernels go without UBSan: they compile in seconds so, not in minutes.
ASAN := address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer --param asan-instrumentation-with-call-threshold=0
asan:   ## the specs under AddressSanitizer and UBSan (in build/asan)
	@$(MAKE) --no-print-directory BUILD=$(BUILD)/asan OPT='-O1 -g' SANITIZE='-fsanitize=$(ASAN)' SANITIZE_gen=-fno-sanitize=undefined all
	@BUILD=$(abspath $(BUILD))/asan SPEC_LUAS='$(or $(SPEC_LUAS),lua5.4)' SPEC_PREFIX="env \
	  LD_PRELOAD=$$($(CC) -print-file-name=libasan.so):$$($(CC) -print-file-name=libubsan.so) \
	  ASAN_OPTIONS=detect_leaks=0:detect_odr_violation=0:allocator_may_return_null=1 UBSAN_OPTIONS=print_stacktrace=1" spec/run $(SPEC)

FORMATTED  = $(shell find csrc spec examples/c -name gen -prune -o \( -name '*.[ch]' -o -name '*.cpp' \) -print)
format:   ## lay out the C sources
	clang-format -i $(FORMATTED)

help:   ## this list
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## */\t/' | expand -t 12

clean:   ## remove build and out
	rm -rf $(BUILD) $(OUT)
	$(if $(filter-out clean help,$(MAKECMDGOALS)),@$(link_headers))

# What objects and programs depend on, as the compiler found it: in the folders of rooms, four deep at most.
-include $(if $(filter-out gen gen-check,$(OWN_WORK)),$(foreach d,obj $(ABIS:%=%/obj) bench check fuzz,$(wildcard $(addprefix $(BUILD)/$(d)/,*.d */*.d */*/*.d */*/*/*.d */*/*/*/*.d))))
