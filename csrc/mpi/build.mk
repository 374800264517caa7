# Teams of processes, by MPI. Built where its headers are; without them `make` goes on, and programs that mpirun has started
# say what to install. MPICC names another MPI's compiler.

MPICC       ?= mpicc
MPI_CFLAGS  := $(or $(call pkg,--cflags,ompi-c),$(shell $(MPICC) --showme:compile 2>/dev/null || $(MPICC) -compile_info 2>/dev/null | grep -o -- '-I[^ ]*'))
MPI_LIBS    := $(or $(call pkg,--libs,ompi-c),$(shell $(MPICC) --showme:link 2>/dev/null || $(MPICC) -link_info 2>/dev/null | grep -o -- '-[LlW][^ ]*'))
WITH_MPI    ?= $(if $(filter -l%,$(MPI_LIBS)),y)
OBJ_mpi     := $(call objects,mpi)

ifneq ($(WITH_MPI),)
LIBS += $(BUILD)/lib/libylm_mpi.so
HAVE += mpi
endif

$(BUILD)/obj/mpi/%.o: csrc/mpi/%.c
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(CC) $(CFLAGS) $(patsubst -I%,-isystem %,$(MPI_CFLAGS)) -c $< -o $@

$(BUILD)/lib/libylm_mpi.so: $(OBJ_mpi) $(BUILD)/lib/libylm.so Makefile
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(CC) $(filter-out -fopenmp,$(LDFLAGS)) $(SONAME) -Wl,-rpath,'$$ORIGIN' $(OBJ_mpi) -L$(BUILD)/lib -lylm $(MPI_LIBS) -lpthread -o $@ $(LINKED)
