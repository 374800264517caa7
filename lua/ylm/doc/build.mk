# Documentation from the entries beside the code: docs/api.md, which is checked in, and into build/docs pages by LDoc and
# ylm.meta.lua with annotations for editors (LuaLS).

api: all    ## docs/api.md, as the entries beside the code say it
	@$(BUILD)/ylm run lua/ylm/doc/main.lua docs --api

page-pictures: all   ## docs/images/page.png, from a page in headless Chromium
	@$(BUILD)/ylm run spec/support/page_pictures.lua

docs: all   ## build/docs: pages (LDoc), annotations for editors (ylm.meta.lua)
	@$(BUILD)/ylm run lua/ylm/doc/site.lua . $(BUILD)/docs && echo $(BUILD)/docs/index.html
	@$(BUILD)/ylm run lua/ylm/doc/main.lua $(BUILD)/docs && echo $(BUILD)/docs/ylm.meta.lua
	@$(BUILD)/ylm run lua/ylm/doc/site.lua --check $(BUILD)/docs
