# Installing: libraries with their version, a static core, public headers, files for pkg-config and CMake, Lua files, the
# tool with its man page and completions, annotations for editors.

INSTALL ?= install
STRIP   ?= strip
D        = $(DESTDIR)$(PREFIX)
version  = $(patsubst lua%,%,$(1))

# Headers of the libraries that are built, less those of the last column of csrc/README.md, that only the libraries' own files include.
PRIVATE   = $(filter ylm_%,$(shell sed -n 's/^| [a-z]* |[^|]*| \(`.*\) |$$/\1/p' csrc/README.md | tr '`,' '  '))
FOLDERS   = $(CORE) $(if $(WITH_CODEC),$(CODEC)) $(if $(WITH_SCENE),$(SCENE)) $(filter $(TOPS),$(HAVE))
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
	  -e '$(if $(filter ylm,$(1)),,/@PRIVATE@/d;)s|@PRIVATE@|Libs.private: -lm -fopenmp|' \
	  -e '$(if $(filter ylm,$(1)),/@REQUIRES@/d,s|@REQUIRES@|Requires: ylm = $(VERSION)|)' package/ylm.pc.in > $(D)/lib/pkgconfig/$(1).pc

endef

# What is made of the texts beside the code: annotations, the man page, completions. One Lua that ylm was built for makes them.
TEXTS     := $(addprefix $(BUILD)/share/,ylm.meta.lua ylm.1 ylm.bash _ylm ylm.fish)
TEXTS_LUA  = $(or $(ROCK_LUA),$(firstword $(LUAS)))
ifneq ($(LUAS),)
$(BUILD)/share/made: $(LIBS) $(BINDINGS) $(BUILD)/ylm $(shell find lua -name '*.lua')
	@mkdir -p $(@D)
	$(call say,DOC,$(@D))
	$(Q)for program in doc/main.lua cli/install.lua; do \
	  YLM_LUA='$(TEXTS_LUA)' $(BUILD)/ylm run lua/ylm/$$program $(@D) || exit; done
	$(Q)touch $@
INSTALL_TEXTS := $(BUILD)/share/made
endif

# Installs them below the folder $(1).
define INSTALL_SHARE
	$(INSTALL) -d $(1)/ylm $(1)/man/man1 $(1)/bash-completion/completions $(1)/zsh/site-functions $(1)/fish/vendor_completions.d
	$(INSTALL) -m 644 $(BUILD)/share/ylm.meta.lua $(1)/ylm/ylm.meta.lua
	$(INSTALL) -m 644 $(BUILD)/share/ylm.1 $(1)/man/man1/ylm.1
	$(INSTALL) -m 644 $(BUILD)/share/ylm.bash $(1)/bash-completion/completions/ylm
	$(INSTALL) -m 644 $(BUILD)/share/_ylm $(1)/zsh/site-functions/_ylm
	$(INSTALL) -m 644 $(BUILD)/share/ylm.fish $(1)/fish/vendor_completions.d/ylm.fish
endef

# Lua files, and the page viewer's sources, which stand beside the module that reads them.
LUA_FILES := \( -name '*.lua' -o -path 'ylm/page/viewer/*' \) -type f

# The core for programs that take it along; kernels are objects like any other.
$(BUILD)/lib/libylm.a: $(OBJ_core) Makefile
	@mkdir -p $(@D)
	$(call say,AR,$@)
	$(Q)rm -f $@ && $(AR) rcs $@ $(OBJ_core)

.PHONY: static
static: $(BUILD)/lib/libylm.a   ## build/lib/libylm.a, the core for programs that are linked without shared libraries

# A room's init.lua takes the place of an older ylm's file, which Lua would find first.
install: all static $(INSTALL_TEXTS)   ## install libraries, headers, Lua files and the tool (PREFIX, DESTDIR)
	$(INSTALL) -d $(D)/bin $(D)/lib/pkgconfig $(D)/lib/cmake/ylm $(D)/include/ylm
	$(foreach l,$(patsubst lib%.so,%,$(notdir $(LIBS))),$(call INSTALL_LIBRARY,$(l)))
	$(INSTALL) -m 644 $(BUILD)/lib/libylm.a $(D)/lib && $(STRIP) -g $(D)/lib/libylm.a
	rm -f $(addprefix $(D)/include/ylm/,$(PRIVATE))
	$(INSTALL) -m 644 $(HEADERS) $(D)/include/ylm
	$(INSTALL) -m 644 package/ylmConfig.cmake $(D)/lib/cmake/ylm
	sed -e 's|@VERSION@|$(VERSION)|' package/ylmConfigVersion.cmake.in > $(D)/lib/cmake/ylm/ylmConfigVersion.cmake
	set -e; for v in $(foreach a,$(ABIS),$(call version,$(a))); do \
	  for f in $(patsubst lua/%/init.lua,%.lua,$(wildcard lua/ylm/*/init.lua)); do rm -f $(D)/share/lua/$$v/$$f; done; \
	  for d in $$(cd lua && find ylm $(LUA_FILES) -printf '%h\n' | sort -u); do $(INSTALL) -d $(D)/share/lua/$$v/$$d; \
	    $(INSTALL) -m 644 $$(cd lua && find $$d -maxdepth 1 $(LUA_FILES) -printf 'lua/%p ') $(D)/share/lua/$$v/$$d; done; \
	  $(INSTALL) -d $(D)/lib/lua/$$v/ylm/c; $(INSTALL) -m 755 $(BUILD)/lua$$v/ylm/c/*.so $(D)/lib/lua/$$v/ylm/c; done
	sed -e 's|@ROOT@||; s|@LUA@|$(PREFIX)/share/lua/$$v|g; s|@C@|$(PREFIX)/lib/lua/$$v|' lua/ylm/cli/ylm.in > $(D)/bin/ylm
	chmod 755 $(D)/bin/ylm
	$(if $(INSTALL_TEXTS),$(call INSTALL_SHARE,$(D)/share))
	$(if $(DESTDIR),,@package/paths '$(PREFIX)' $(LUAS))

# Called by rockspec/ylm-scm-1.rockspec with LuaRocks' LUADIR, LIBDIR and BINDIR, and the rock's own folder.
rock: all $(INSTALL_TEXTS)
	cd lua && find ylm $(LUA_FILES) -exec $(INSTALL) -D -m 644 {} $(LUADIR)/{} \;
	$(INSTALL) -d $(LIBDIR)/ylm/c $(BINDIR)
	$(INSTALL) -m 755 $(BUILD)/$(ABIS)/ylm/c/*.so $(LIBDIR)/ylm/c
	for l in $(LIBS); do $(INSTALL) -m 755 $$l $(LIBDIR)/ylm/c/$${l##*/}.$(SOVERSION) || exit; done
	$(INSTALL) -m 755 lua/ylm/cli/main.lua $(BINDIR)/ylm
	$(if $(ROCK_DIR),$(call INSTALL_SHARE,$(ROCK_DIR)/share))
	@echo "ylm: man page, completions and annotations for editors are in the rock's folder, below share:"
	@echo '  $$(luarocks show --rock-dir ylm)/share'
