# The VTK part: the only C++. Built where the headers are; without them `make` goes on and ylm.view says what to install.

VTK_INCLUDE := $(lastword $(sort $(wildcard /usr/include/vtk-9.* /usr/local/include/vtk-9.*)))
VTK_VERSION := $(patsubst vtk-%,%,$(notdir $(VTK_INCLUDE)))
VTK_MODULES := ChartsCore CommonColor CommonCore CommonDataModel CommonExecutionModel CommonMath CommonMisc CommonTransforms \
               FiltersCore FiltersSources FiltersGeneral IOExport IOGeometry IOImage IOXML ImagingCore InteractionStyle \
               RenderingAnnotation RenderingContext2D RenderingContextOpenGL2 RenderingCore RenderingFreeType \
               RenderingOpenGL2 RenderingVolume RenderingVolumeOpenGL2
OBJ_vtk     := $(BUILD)/obj/vtk/all.o

ifneq ($(and $(VTK_INCLUDE),$(wildcard csrc/lua/vtk/vtk.c)),)
LIBS += $(BUILD)/lib/libylm_vtk.so
HAVE += vtk
endif

# Pages (plot:save "x.pdf") by libharu, which VTK itself depends on.
HPDF := $(wildcard /usr/include/hpdf.h /usr/local/include/hpdf.h)

CXXFLAGS := -std=c++17 -fPIC -fvisibility=hidden -MMD -MP $(OPT) $(filter-out -Wshadow,$(WARN)) $(SANITIZE) \
            -I$(INCLUDE) -isystem $(VTK_INCLUDE) \
            $(if $(HPDF),-DYLM_WITH_HPDF)

# All sources are one unit: VTK's headers take most of the time, and are read once.
$(BUILD)/obj/vtk/all.cpp: csrc/vtk csrc/vtk/build.mk
	@mkdir -p $(@D)
	@printf '#include "%s"\n' $(wildcard csrc/vtk/*.cpp) > $@

$(BUILD)/obj/vtk/all.o: $(BUILD)/obj/vtk/all.cpp
	$(call say,CXX,$@)
	$(Q)$(VTK_CXX) $(CXXFLAGS) $(HAND_ON) -iquote . -c $< -o $@

# The compiler launcher of CC, if any, serves C++ too.
VTK_CXX := $(if $(filter ccache,$(firstword $(CC))),ccache )$(CXX)

$(BUILD)/lib/libylm_vtk.so: $(OBJ_vtk) $(BUILD)/lib/libylm.so Makefile
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(VTK_CXX) $(LDFLAGS) $(SONAME) -Wl,-rpath,'$$ORIGIN' $(OBJ_vtk) -L$(BUILD)/lib -lylm \
	  $(foreach m,$(VTK_MODULES),-lvtk$(m)-$(VTK_VERSION)) -lvtksys-$(VTK_VERSION) -lGLEW -lOpenGL -lEGL -lGLX -lX11 $(if $(HPDF),-lhpdf) -o $@ $(LINKED)
