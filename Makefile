# ylm - spherical-harmonic lighting for Lua. `make help` lists the targets.

SHELL   := /bin/bash
BUILD   ?= build
OUT     ?= out
PREFIX  ?= /usr/local
CC      ?= cc
CXX     ?= c++
AR      ?= ar
OPT     ?= -O3 -g
WARN    := -Wall -Wextra -Wshadow -Wpointer-arith -Wvla
CWARN   := $(WARN) -Wstrict-prototypes -Wmissing-prototypes
SANITIZE ?=
V       ?=
Q       := $(if $(V),,@)
say      = @printf '  %-4s %s\n' $(1) $(2)
LUAS    ?= $(foreach l,lua5.1 luajit lua5.3 lua5.4,$(if $(shell command -v $(l)),$(l)))
ABIS    := $(sort $(patsubst luajit,lua5.1,$(LUAS)))

# -- what belongs to which library (DESIGN: the ladder) -------------------------

CORE    := base sh image geom material light grid figure
SCENE   := codec trace shade

ARCH    := $(shell $(CC) -dumpmachine | cut -d- -f1)
ISAS    := $(if $(filter x86_64,$(ARCH)),sse2 avx2 avx512,$(if $(filter aarch64,$(ARCH)),neon))
FLAGS_sse2   := -msse2 -DYLM_VECTOR_BYTES=16
FLAGS_neon   := -DYLM_VECTOR_BYTES=16
FLAGS_avx2   := -mavx2 -mfma -DYLM_VECTOR_BYTES=32
FLAGS_avx512 := -mavx512f -mavx512dq -mavx512vl -mavx512bw -mavx2 -mfma -mprefer-vector-width=512 -DYLM_VECTOR_BYTES=64

CFLAGS  := -std=gnu11 -fPIC -fvisibility=hidden -fopenmp -fno-math-errno -fno-trapping-math -MMD -MP \
           $(OPT) $(CWARN) $(SANITIZE) -Icsrc $(foreach d,$(CORE) $(SCENE) vulkan vtk,-Icsrc/$(d))
LDFLAGS := -shared -fopenmp $(SANITIZE) -Wl,-z,now $(if $(SANITIZE),,-Wl,-z,defs)

pkg      = $(shell pkg-config $(1) $(2) 2>/dev/null)
CFLAGS_codec = $(call pkg,--cflags,OpenEXR libpng)
LIBS_scene   = -lOpenEXRCore-3_1 $(call pkg,--libs,libpng) -lembree3

# -- objects: csrc/x/*.c once, csrc/x/*.isa.c once per instruction set ----------

sources = $(filter-out %.isa.c,$(wildcard csrc/$(1)/*.c csrc/$(1)/gen/*.c))
kernels = $(wildcard csrc/$(1)/*.isa.c csrc/$(1)/gen/*.isa.c)
objects = $(patsubst csrc/%.c,$(BUILD)/obj/%.o,$(call sources,$(1))) \
          $(foreach i,$(ISAS),$(patsubst csrc/%.isa.c,$(BUILD)/obj/%.$(i).o,$(call kernels,$(1))))

OBJ_core  := $(foreach d,$(CORE),$(call objects,$(d)))
OBJ_scene := $(foreach d,$(SCENE),$(call objects,$(d)))

LIBS := $(BUILD)/lib/libylm.so $(if $(OBJ_scene),$(BUILD)/lib/libylm_scene.so)
HAVE := core $(if $(wildcard csrc/lua/scene.c),scene)
# Parts with rules of their own.
-include csrc/vtk/build.mk csrc/vulkan/build.mk lua/ylm/codegen/build.mk spec/bench/build.mk spec/fuzz/build.mk lua/ylm/doc/build.mk

BINDINGS := $(foreach a,$(ABIS),$(foreach m,$(HAVE),$(BUILD)/$(a)/ylm/c/$(m).so))

.PHONY: all deps demo test spec bench gen check asan fuzz docs format install clean help
.DEFAULT_GOAL := all

all: $(LIBS) $(BINDINGS) $(BUILD)/ylm   ## build the libraries, a binding for each Lua found, and build/ylm

define KERNEL
$(BUILD)/obj/%.$(1).o: csrc/%.isa.c
	@mkdir -p $$(@D)
	$$(call say,CC,$$@)
	$(Q)$$(CC) $$(CFLAGS) $$(FLAGS_$(1)) -DYLM_ISA=$(1) -c $$< -o $$@
endef
$(foreach i,$(ISAS),$(eval $(call KERNEL,$(i))))

$(BUILD)/obj/codec/%.o: csrc/codec/%.c
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(CC) $(CFLAGS) $(CFLAGS_codec) -c $< -o $@

$(BUILD)/obj/%.o: csrc/%.c
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(CC) $(CFLAGS) -c $< -o $@

$(BUILD)/lib/libylm.so: $(OBJ_core)
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(CC) $(LDFLAGS) -Wl,-soname,libylm.so $^ -lm -o $@

$(BUILD)/lib/libylm_scene.so: $(OBJ_scene) $(BUILD)/lib/libylm.so
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(CC) $(LDFLAGS) -Wl,-soname,libylm_scene.so -Wl,-rpath,'$$ORIGIN' $(OBJ_scene) -L$(BUILD)/lib -lylm $(LIBS_scene) -lm -o $@

# A binding is compiled per Lua ABI and finds the libraries by $ORIGIN.
LIBS_OF_core   := -lylm
LIBS_OF_scene  := -lylm_scene -lylm
LIBS_OF_vtk    := -lylm_vtk -lylm
LIBS_OF_vulkan := -lylm_vulkan -lylm

define BINDING
$(BUILD)/$(1)/obj/%.o: csrc/lua/%.c
	@mkdir -p $$(@D)
	$$(call say,CC,$$@)
	$(Q)$$(CC) $$(CFLAGS) $$(call pkg,--cflags,$(1)) -c $$< -o $$@
$(foreach m,$(HAVE),
$(BUILD)/$(1)/ylm/c/$(m).so: $(patsubst csrc/lua/%.c,$(BUILD)/$(1)/obj/%.o,$(wildcard csrc/lua/binding*.c csrc/lua/$(m).c csrc/lua/$(m)_*.c)) $(LIBS)
	@mkdir -p $$(@D)
	$$(call say,LINK,$$@)
	$(Q)$$(CC) -shared -fopenmp $(SANITIZE) $$(filter %.o,$$^) -L$(BUILD)/lib $(LIBS_OF_$(m)) -Wl,-rpath,'$$$$ORIGIN:$$$$ORIGIN/../../../lib' -lm -o $$@
)
endef
$(foreach a,$(ABIS),$(eval $(call BINDING,$(a))))

$(BUILD)/ylm: lua/ylm/cli/ylm.in Makefile
	@mkdir -p $(@D)
	$(Q)sed -e 's|@ROOT@|$(CURDIR)|; s|@LUA@|$(CURDIR)/lua|g; s|@C@|$(abspath $(BUILD))/lua$$v|' $< > $@ && chmod +x $@

# -- checks ----------------------------------------------------------------------

spec: all   ## run the specs under Lua 5.4 and LuaJIT (SPEC=pattern for some of them)
	@BUILD=$(abspath $(BUILD)) spec/run $(SPEC)

help:   ## this list
	@grep -hE '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## */\t/' | expand -t 12

clean:   ## remove build and out
	rm -rf $(BUILD) $(OUT)

-include $(shell find $(BUILD) -name '*.d' 2>/dev/null)
