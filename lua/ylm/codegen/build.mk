# The generated kernels: lua/ylm/codegen/targets.lua lists them.

CODEGEN_LUA ?= $(firstword $(foreach l,lua5.4 luajit lua5.3 lua5.1,$(if $(shell command -v $(l)),$(l))))

gen:   ## regenerate what stands in gen/ folders
	@LUA_PATH="lua/?.lua;lua/?/init.lua" $(CODEGEN_LUA) lua/ylm/codegen/command.lua --write

gen-check:
	@LUA_PATH="lua/?.lua;lua/?/init.lua" $(CODEGEN_LUA) lua/ylm/codegen/command.lua --check
