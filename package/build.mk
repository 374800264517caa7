# Installing: libraries with their version, public headers, files for pkg-config and CMake, Lua files, the tool.

INSTALL ?= install
D        = $(DESTDIR)$(PREFIX)
version  = $(patsubst lua%,%,$(1))

# Headers of the libraries that are built, less those that only the libraries' own files include.
PRIVATE  := $(addprefix ylm_,intrinsics.h real.h sets.h simd.h vector.h light_device.h sh_rival.h material_rival.h)
FOLDERS   = $(CORE) $(if $(WITH_CODEC),$(CODEC)) $(if $(WITH_SCENE),$(SCENE)) $(filter vtk vulkan rival mpi,$(HAVE))
HEADERS   = $(filter-out $(addprefix %/,$(PRIVATE)),$(wildcard $(FOLDERS:%=csrc/%/ylm_*.h)))

ABOUT_ylm        := spherical harmonics, lights, grids of probes
ABOUT_ylm_codec  := image files for ylm
ABOUT_ylm_scene  := scenes, rays, paths and bounces for ylm
ABOUT_ylm_vtk    := pictures of the mathematics for ylm
ABOUT_ylm_vulkan := ylm on graphics processors
ABOUT_ylm_mpi    := work that many processes share for ylm
ABOUT_ylm_rival  := methods that ylm is compared with

# libylm.so -> libylm.so.0 -> libylm.so.0.1.0, and ylm.pc.
define INSTALL_LIBRARY
	$(INSTALL) -m 755 $(BUILD)/lib/lib$(1).so $(D)/lib/lib$(1).so.$(VERSION)
	ln -sf lib$(1).so.$(VERSION) $(D)/lib/lib$(1).so.$(SOVERSION)
	ln -sf lib$(1).so.$(SOVERSION) $(D)/lib/lib$(1).so
	sed -e 's|@NAME@|$(1)|; s|@VERSION@|$(VERSION)|; s|@ABOUT@|$(ABOUT_$(1))|' \
	  -e '$(if $(filter ylm,$(1)),/@REQUIRES@/d,s|@REQUIRES@|Requires: ylm = $(VERSION)|)' package/ylm.pc.in > $(D)/lib/pkgconfig/$(1).pc

endef

# A room's init.lua takes the place of an older ylm's file, which Lua would find first.
install: all   ## install libraries, headers, Lua files and the tool (PREFIX, DESTDIR)
	$(INSTALL) -d $(D)/bin $(D)/lib/pkgconfig $(D)/lib/cmake/ylm $(D)/include/ylm
	$(foreach l,$(patsubst lib%.so,%,$(notdir $(LIBS))),$(call INSTALL_LIBRARY,$(l)))
	rm -f $(addprefix $(D)/include/ylm/,$(PRIVATE))
	$(INSTALL) -m 644 $(HEADERS) $(D)/include/ylm
	$(INSTALL) -m 644 package/ylmConfig.cmake $(D)/lib/cmake/ylm
	sed -e 's|@VERSION@|$(VERSION)|' package/ylmConfigVersion.cmake.in > $(D)/lib/cmake/ylm/ylmConfigVersion.cmake
	set -e; for v in $(foreach a,$(ABIS),$(call version,$(a))); do \
	  for f in $(patsubst lua/%/init.lua,%.lua,$(wildcard lua/ylm/*/init.lua)); do rm -f $(D)/share/lua/$$v/$$f; done; \
	  for d in $$(cd lua && find ylm -type d); do \
	    $(INSTALL) -d $(D)/share/lua/$$v/$$d; $(INSTALL) -m 644 lua/$$d/*.lua $(D)/share/lua/$$v/$$d; done; \
	  $(INSTALL) -d $(D)/lib/lua/$$v/ylm/c; $(INSTALL) -m 755 $(BUILD)/lua$$v/ylm/c/*.so $(D)/lib/lua/$$v/ylm/c; done
	sed -e 's|@ROOT@||; s|@LUA@|$(PREFIX)/share/lua/$$v|g; s|@C@|$(PREFIX)/lib/lua/$$v|' lua/ylm/cli/ylm.in > $(D)/bin/ylm
	chmod 755 $(D)/bin/ylm

# Called by rockspec/ylm-scm-1.rockspec with LuaRocks' LUADIR, LIBDIR and BINDIR.
rock: all
	cd lua && find ylm -name '*.lua' -exec $(INSTALL) -D -m 644 {} $(LUADIR)/{} \;
	$(INSTALL) -d $(LIBDIR)/ylm/c $(BINDIR)
	$(INSTALL) -m 755 $(BUILD)/$(ABIS)/ylm/c/*.so $(LIBDIR)/ylm/c
	for l in $(LIBS); do $(INSTALL) -m 755 $$l $(LIBDIR)/ylm/c/$${l##*/}.$(SOVERSION) || exit; done
	$(INSTALL) -m 755 lua/ylm/cli/main.lua $(BINDIR)/ylm
