# The rivals: a library of its own, which needs nothing but libylm.so, and is loaded when one of its methods is asked for.

OBJ_rival := $(call objects,rival)
LIBS += $(BUILD)/lib/libylm_rival.so
HAVE += rival

$(BUILD)/lib/libylm_rival.so: $(OBJ_rival) $(BUILD)/lib/libylm.so Makefile
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(CC) $(filter-out -fopenmp,$(LDFLAGS)) $(SONAME) -Wl,-rpath,'$$ORIGIN' $(OBJ_rival) -L$(BUILD)/lib -lylm -lm -o $@ $(LINKED)
