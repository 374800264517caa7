# Documentation from the entries beside the code, into build/docs: pages by LDoc, api.md, and
# ylm.meta.lua with annotations for editors (LuaLS). Nothing generated is checked in.

docs: all   ## build/docs: pages (LDoc), api.md, annotations for editors (ylm.meta.lua)
	@rm -rf $(BUILD)/doc-input && mkdir -p $(BUILD)/doc-input $(BUILD)/docs
	@$(BUILD)/ylm run lua/ylm/doc/main.lua $(BUILD)/doc-input --ldoc
	@cp lua/ylm/doc/config.ld $(BUILD)/doc-input/
	@cp README.md CHANGELOG.md $(filter-out docs/README.md,$(wildcard docs/*.md)) $(BUILD)/doc-input/
	@cd $(BUILD)/doc-input && ldoc -q -c config.ld -d ../docs . >/dev/null && echo $(BUILD)/docs/index.html
	@$(BUILD)/ylm run lua/ylm/doc/main.lua $(BUILD)/docs && echo $(BUILD)/docs/api.md && echo $(BUILD)/docs/ylm.meta.lua
