# Documentation from the entries beside the code: docs/ylm.meta.lua, docs/api.md, and pages by LDoc.

docs: all   ## regenerate docs/api.md and docs/ylm.meta.lua; pages in build/docs
	@mkdir -p $(BUILD)/doc-input
	@rm -f $(BUILD)/doc-input/*
	@$(BUILD)/ylm run lua/ylm/doc/main.lua --ldoc $(BUILD)/doc-input
	@cp lua/ylm/doc/config.ld $(BUILD)/doc-input/
	@for t in README.md docs/conventions.md docs/math.md docs/references.md docs/performance.md CHANGELOG.md; do \
	  if [ -f $$t ]; then cp $$t $(BUILD)/doc-input/; fi; done
	@cd $(BUILD)/doc-input && ldoc -q -c config.ld -d ../docs . && echo $(BUILD)/docs/index.html

docs-check: all
	@$(BUILD)/ylm run lua/ylm/doc/main.lua --check
