# SPDX-License-Identifier: Apache-2.0
# Short names for what CMake and the tools do. `make help` lists them.
PRESET ?= release
BUILD := build/$(PRESET)
PYTHON := build/venv/bin/python3

.DEFAULT_GOAL := help
.PHONY: help setup build demo test formal bench lint format install clean

help: ## list the targets
	@awk -F':.*## ' '/^[a-z-]+:.*## /{printf "  make %-10s %s\n", $$1, $$2}' Makefile

setup: ## install what is missing (Debian packages, build/venv); nothing when all is there
	@tools/setup

build: setup ## configure and build everything
	@cmake --preset $(PRESET) >build/configure.log 2>&1 || { cat build/configure.log; exit 1; }
	@cmake --build --preset $(PRESET)

demo: build ## shape → image → simulated FPGA → focus in the air: table and pictures in build/demo
	@$(PYTHON) tools/demo.py --program $(BUILD)/host/cli/haptogram --output build/demo

test: build ## every test: units, co-simulation, command line, proofs, RTL lint
	@ctest --preset $(PRESET) -j 2

formal: build ## the proofs alone, with a line each
	@$(PYTHON) tests/formal/run.py --build build/formal

bench: build ## the project's numbers beside their targets, as a table and build/bench.json
	@$(PYTHON) tools/bench.py --build $(BUILD) --output build/bench.json

lint: build ## RTL lint, formatting, generated files, clang-tidy
	@tools/lint --all

format: setup ## format the C++ sources in place
	@git ls-files '*.cpp' '*.hpp' | grep -v host/image/interface.hpp | xargs clang-format -i

install: build ## install the program and its arrays (DESTDIR and CMAKE_INSTALL_PREFIX as usual)
	@cmake --install $(BUILD)

clean: ## remove everything that was built, but for the Python environment
	@find build -mindepth 1 -maxdepth 1 ! -name venv -exec rm -rf {} + 2>/dev/null || true
