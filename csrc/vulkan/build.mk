# The Vulkan part: built where the headers and glslc are; without them `make` goes on and ylm.vulkan says what to install.
# Nothing is linked: libvulkan is opened at run time. shaders/*.comp become SPIR-V that the library holds.

GLSLC       ?= glslc
GLSLFLAGS   := --target-env=vulkan1.2 -O -Werror -fshader-stage=comp -mfmt=c -Ishaders -Ishaders/gen
SHADERS     := $(patsubst shaders/%.comp,%,$(filter-out %.real.comp,$(wildcard shaders/*.comp))) \
               $(foreach s,$(patsubst shaders/%.real.comp,%,$(wildcard shaders/*.real.comp)),$(s)_float $(s)_double)
# Kernels of sums once more, for low lmax alone: modules a quarter as long, which drivers take as much sooner.
LOW         := moments flat flat_second product
SHADERS     += $(foreach s,$(LOW),$(s)_low_float $(s)_low_double)
SPIRV       := $(BUILD)/obj/vulkan/spirv
OBJ_vulkan  := $(call objects,vulkan) $(BUILD)/obj/vulkan/shaders.o
WITH_VULKAN ?= $(and $(wildcard csrc/lua/vulkan/vulkan.c),$(wildcard /usr/include/vulkan/vulkan.h /usr/local/include/vulkan/vulkan.h),\
                 $(shell command -v $(GLSLC)))

ifneq ($(WITH_VULKAN),)
LIBS += $(BUILD)/lib/libylm_vulkan.so
HAVE += vulkan
endif

# Every file that is included becomes a target of its own without a rule (gcc's -MP), so that deleting one breaks nothing.
define GLSL
	@mkdir -p $(@D)
	$(call say,GLSL,$@)
	$(Q)$(GLSLC) $(GLSLFLAGS) $(1) -MD -MF $@.d -MT $@ $< -o $@
	@for f in $$(sed 's/^[^:]*://; s/\\$$//' $@.d); do echo "$$f:"; done > $@.p && cat $@.p >> $@.d && rm $@.p
endef

$(SPIRV)/%_float.inc: shaders/%.real.comp
	$(call GLSL)
$(SPIRV)/%_double.inc: shaders/%.real.comp
	$(call GLSL,-DYLM_DOUBLE)
$(SPIRV)/%_low_float.inc: shaders/%.real.comp
	$(call GLSL,-DYLM_LOW)
$(SPIRV)/%_low_double.inc: shaders/%.real.comp
	$(call GLSL,-DYLM_LOW -DYLM_DOUBLE)
$(SPIRV)/%.inc: shaders/%.comp
	$(call GLSL)

# One table of all kernels, by name.
$(BUILD)/obj/vulkan/shaders.c: $(foreach s,$(SHADERS),$(SPIRV)/$(s).inc) csrc/vulkan/build.mk
	@mkdir -p $(@D)
	@{ echo '#include "device/gpu.h"'; for s in $(SHADERS); do \
	  echo "static const uint32_t code_$$s[] ="; echo "#include \"spirv/$$s.inc\""; echo ';'; done; \
	  echo 'const ylm__shader ylm__shaders[] = {'; for s in $(SHADERS); do \
	  echo "    {\"$$s\", code_$$s, sizeof code_$$s},"; done; echo '    {NULL, NULL, 0}};'; } > $@

$(BUILD)/obj/vulkan/shaders.o: $(BUILD)/obj/vulkan/shaders.c
	$(call say,CC,$@)
	$(Q)$(CC) $(CFLAGS) -Icsrc/vulkan -c $< -o $@

$(BUILD)/lib/libylm_vulkan.so: $(OBJ_vulkan) $(BUILD)/lib/libylm.so Makefile
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(CC) $(LDFLAGS) $(SONAME) -Wl,-rpath,'$$ORIGIN' $(OBJ_vulkan) -L$(BUILD)/lib -lylm -ldl -lm -o $@ $(LINKED)

