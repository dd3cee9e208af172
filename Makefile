# SPDX-License-Identifier: Apache-2.0
# Short names for what CMake and the tools do. `make help` lists them.
PRESET ?= release
BUILD := build/$(PRESET)
# What tools/setup made, or any Python with the modules that CMake asks for.
PYTHON := $(firstword $(wildcard build/venv/bin/python3) python3)

# An empty environment has neither, and ccache wants both.
PATH := $(or $(PATH),/usr/local/bin:/usr/bin:/bin)
HOME := $(or $(HOME),$(shell { getent passwd $$(id -u) | cut -d: -f6; } 2>/dev/null))
export PATH HOME

.DEFAULT_GOAL := help
.PHONY: help setup build check cosim deep deep-build demo real-time test messages browser hardware mutants sanitize bitstream bitstreams flash soak formal bench figures docs site lint format install dist fresh clean

help: ## list the targets
	@awk -F':.*## ' '/^[a-z-]+:.*## /{printf "  make %-10s %s\n", $$1, $$2}' Makefile

setup: ## install what is missing on Debian 12, TIER=demo, board, test, dev or hardware; nothing when all is there. Other targets install nothing, but bench and dist, in build/
	@tools/setup $(TIER)

# $(call need,PROGRAMS): one line when some are missing. What the libraries need, CMake says, in one line, too.
need = missing=; for program in $(1); do command -v $$program >/dev/null || missing="$$missing $$program"; done; \
  [ -z "$$missing" ] || { echo "make: missing:$$missing. On Debian 12 tools/setup $(2)installs all that is needed; elsewhere install it by the system's own means." >&2; exit 1; }
# $(call configure,PRESET)
configure = $(call need,cmake ninja c++ python3); mkdir -p build; cmake --preset $(1) >build/configure-$(1).log 2>&1 \
  || { grep '^haptogram: missing' build/configure-$(1).log >&2 || cat build/configure-$(1).log >&2; exit 1; }

build: ## configure and build everything; PRESET=dev with debugger and sanitizers, in build/dev
	@$(call configure,$(PRESET))
	@cmake --build --preset $(PRESET)

# The program of `make build` if it is there. Otherwise it is built as one simulated core needs it, with the extra feel alone and without tests.
DEMO := $(if $(wildcard build/release/host/cli/haptogram),release,quick)
demo: ## shape → image → simulated FPGA → focus in the air: table and pictures in build/demo
	@$(call configure,$(DEMO))
	@[ $(DEMO) = release ] || echo "make: building the program, some three minutes on two processors; then 15 seconds for two shapes"
	@cmake --build --preset $(DEMO) --target haptogram
	@$(PYTHON) tools/demo.py --program build/$(DEMO)/host/cli/haptogram --output build/demo

# The same random numbers in each run, so that who changes something is told of that and not of a rare case that was there before;
# SEED= takes others, as CI does each night. Each size of test is labels of ctest: tests/README.md says which case has which.
SEED ?= 1
CTEST := HAPTOGRAM_SEED=$(SEED) ctest --preset $(PRESET)
check: build ## while working, 90 s: the way from a shape to its field, contracts of the small core, units
	@$(CTEST) -j 2 -L '^(unit|check)$$'
	@$(CTEST) -j 2 -R '^cosim/contract [1-6]:'

CASE ?= contract 2
cosim: ## a change of the RTL tried in a minute: the cases that begin with CASE="contract 2" on the smallest simulated core
	@$(call configure,$(PRESET))
	@cmake --build --preset $(PRESET) --target test_cosim_small
	@$(BUILD)/tests/test_cosim_small '~[wide]~[tile100]$(CASE)*' --rng-seed $(SEED)

# What the cases heard is compared last, and told: a wording that has changed fails nothing.
test: build ## every capability and contract, the same on any machine: units, co-simulation, command line, proofs, lint; not the deep ones
	@rm -rf $(BUILD)/messages
	@$(CTEST) -j 2 -LE '^(check|deep|real-time|studio_browser|messages)$$'; ran=$$?; \
	  $(CTEST) -L '^messages$$' || echo "make: what people are told has changed, or was heard by other cases; make messages records it" >&2; exit $$ran

messages: build ## run the tests that hear messages, and write tests/messages.txt, to be read with git diff; ONLY=unit/... only some
	@rm -rf $(BUILD)/messages
	@HAPTOGRAM_RECORD_MESSAGES=1 $(CTEST) -j 2 $(if $(ONLY),-R '$(ONLY)',-L '^(unit|cosim|live|reference|studio|tiles|ftdi|suites)$$') \
	  && $(PYTHON) tests/messages.py --record $(if $(ONLY),,--whole) --heard $(BUILD)/messages && git diff --stat tests/messages.txt

real-time: build ## what needs this machine's own time, alone: its figures beside their targets; fails beyond three times those
	@$(CTEST) -L '^real-time$$' -V

# Software WebGL wants a processor to itself, and some minutes; a file that fails is run once more (tests/studio/run.mjs).
browser: build ## the studio's page in Chromium; not part of `make test`
	@$(call need,chromium,dev )
	@if command -v emcc >/dev/null; then $(MAKE) --no-print-directory site; \
	else echo "make: the static page is left out: it needs emcc; on Debian 12 tools/setup dev installs it" >&2; fi
	@ctest --preset $(PRESET) -R '^studio_browser$$' --output-on-failure --no-tests=error

hardware: build ## the driver tile's netlist, simulation, board and Gerbers into build/hardware, each check beside its bound; not part of `make test`
	@$(call need,ngspice pcbnew,hardware )
	@$(PYTHON) extras/hardware/check.py --program $(BUILD)/host/cli/haptogram --output build/hardware

# Each of some 620 faults runs in simulation until a test notices it: hours, so it is not part of `make test`.
mutants: deep-build ## would the tests notice a fault in the RTL; not part of `make test`
	@ctest --preset deep -R '^mutation$$' --output-on-failure

# The contracts' cases again, on the netlists of a small core and of the core as it is placed for a board, which must be within its
# budget; what the cases reach of the RTL; every reader and parser under a fuzzer. All of it takes longer than `make test`, so it is not part of that.
deep: build deep-build ## netlists, budgets, coverage, fuzzers, long proofs, planted bugs, other builds; not part of `make test`
	@$(CTEST) -L '^deep$$'
	@ctest --preset deep -j 2 -E '^mutation$$'

deep-build: build/boards/ice40-hx8k-breakout/report.json
	@$(call configure,deep)
	@cmake --build --preset deep

BITSTREAM_INPUTS := $(wildcard rtl/*.v rtl/*.vh rtl/*/*.v constraints/*.toml) tools/bitstream.py tools/interface.toml
build/boards/%/report.json: $(BITSTREAM_INPUTS)
	@$(call need,yosys)
	@$(PYTHON) tools/bitstream.py $*

BOARD ?= ice40-hx8k-breakout
PROGRAM := $(firstword $(wildcard build/release/host/cli/haptogram build/quick/host/cli/haptogram))
bitstream: ## synthesise, place and route BOARD=… into build/boards, SEEDS=1; fails beyond the budget. Images can be put in only with a built program
	@$(call need,yosys,board )
	@$(PYTHON) tools/bitstream.py $(BOARD) --seeds $(or $(SEEDS),1) $(if $(PROGRAM),--program $(PROGRAM),--empty)

bitstreams: build ## the same for every board, and the core with 256 channels, without and with amplitudes; their table goes to constraints/builds.md
	@$(PYTHON) tools/bitstream.py --seeds $(or $(SEEDS),1) --program $(BUILD)/host/cli/haptogram --table constraints/builds.md
	@$(PYTHON) tools/bitstream.py colorlight-5a-75e-v7.1 --configuration wide-256 --table constraints/builds.md
	@$(PYTHON) tools/bitstream.py colorlight-5a-75e-v7.1 --configuration amplitudes-256 --table constraints/builds.md

# With IMAGE, the image is in the bitstream and plays at power-up with AUTOSTART=1; FLASH=write keeps it when power is cut.
flash: ## load BOARD=… through openFPGALoader, with IMAGE=… in it if given; DRY_RUN=1 only says how
	@$(PYTHON) tools/flash.py $(BOARD) --program $(or $(PROGRAM),haptogram) $(if $(IMAGE),--image $(IMAGE)) $(if $(AUTOSTART),--autostart) \
	  $(if $(filter write,$(FLASH)),--write) $(if $(DRY_RUN),--dry-run)

# Every command before a board that lies, `serve` before clients that do, and random command lines over every source and verb, RUNS=300.
sanitize: ## the program, and the C examples, under address and undefined-behaviour sanitizers, half an hour; not part of `make test`
	@$(call configure,dev)
	@cmake --build --preset dev --target haptogram haptogram_c
	@HAPTOGRAM_LIBRARY=$(CURDIR)/build/dev/host/c/libhaptogram.so HAPTOGRAM_CFLAGS=-fsanitize=address,undefined $(PYTHON) -m pytest -q -p no:cacheprovider tests/c -k examples
	@HAPTOGRAM_PROGRAM=$(CURDIR)/build/dev/host/cli/haptogram HAPTOGRAM_SLOWER=4 $(PYTHON) -m pytest -q -p no:cacheprovider tests/torture -k program
	@HAPTOGRAM_PROGRAM=$(CURDIR)/build/dev/host/cli/haptogram HAPTOGRAM_SLOWER=4 $(PYTHON) -m pytest -q -p no:cacheprovider -m 'not real_time' tests/serve
	@$(PYTHON) tests/fuzz/command_lines.py --program build/dev/host/cli/haptogram --runs $(or $(RUNS),300) --seed $(or $(SEED),1)

soak: build ## torture of the link, boards on one wire, reference board and fuzzers at full size: hours; FUZZ_RUNS=10000000 of each target
	@HAPTOGRAM_SOAK=1 $(BUILD)/tests/test_torture --durations yes
	@HAPTOGRAM_SOAK=1 $(BUILD)/tests/test_cosim '[storm]' --durations yes
	@for part in carrier_edges width_small width_100 net_core net_sdram; do HAPTOGRAM_SOAK=1 $(BUILD)/tests/modules/test_module_$$part --durations yes || exit 1; done
	@HAPTOGRAM_SOAK=1 $(BUILD)/tests/test_live 'live: rings by the thousand*' --durations yes
	@HAPTOGRAM_SOAK=1 HAPTOGRAM_MODEL=rtl $(BUILD)/tests/test_tiles --durations yes
	@HAPTOGRAM_MODEL=rtl HAPTOGRAM_ARRAYS=12 HAPTOGRAM_CASES=2 HAPTOGRAM_PROGRAM=$(CURDIR)/$(BUILD)/host/cli/haptogram $(PYTHON) -m pytest -q -p no:cacheprovider -m 'not real_time' tests/cli tests/python
	@HAPTOGRAM_SOAK=1 $(BUILD)/tests/test_reference --durations yes
	@$(PYTHON) tests/fuzz/run.py --program $(BUILD)/host/cli/haptogram --runs $(or $(FUZZ_RUNS),10000000)

formal: ## the proofs alone and their planted bugs, with a line each
	@$(call need,yosys z3)
	@$(PYTHON) tests/formal/run.py --build build/formal

# Peers are measured where they install: into a virtual environment of their own, which nothing else uses.
build/peers/installed: tools/bench/peers.txt
	@python3 -m venv build/peers && build/peers/bin/pip install --quiet --disable-pip-version-check -r $< && cp $< $@ \
	  || { rm -rf build/peers; echo "make: the peers of tools/bench/peers.txt could not be installed; bench goes on without them" >&2; }

bench: build build/peers/installed ## the project's numbers beside their targets and other libraries, as a table and build/bench.json; ONLY="render field" only parts
	@cmake --build --preset $(PRESET) --target haptogram_benchmarks
	@$(PYTHON) tools/bench.py --build $(BUILD) --output build/bench.json $(if $(ONLY),--only $(ONLY))

figures: build ## the papers' figures, computed, beside the papers' numbers: build/figures/index.html
	@$(PYTHON) extras/papers/figures.py --program $(BUILD)/host/cli/haptogram --tool $(BUILD)/extras/papers/haptogram_figures --output build/figures

docs: ## the site of all pages, with its reference, in build/site; dead links and warnings are errors
	@$(call need,doxygen mkdocs,dev )
	@$(call configure,$(PRESET))
	@cmake --build --preset $(PRESET) --target haptogram haptogram_c
	@$(PYTHON) tools/docs.py --build $(BUILD)

# The engine is built where Emscripten is alone, so that all else needs none.
site: ## the studio as a page for any web host, in build/site/studio: the engine as WebAssembly; after `make docs`, which empties build/site
	@$(call need,emcc cmake ninja node,dev )
	@[ -d extras/studio/web/node_modules/esbuild ] || { echo "make: missing: the packages of extras/studio/web. On Debian 12 tools/setup installs all that is needed." >&2; exit 1; }
	@$(call configure,wasm)
	@cmake --build --preset wasm
	@node extras/studio/web/build.mjs build/site/studio build/wasm/extras/studio/wasm
	@[ ! -f build/site/index.html ] || sed -i 's|<!-- try it:.* -->|<p><a href="studio/index.html">Try it in this browser</a>: design a shape and see its field, with nothing to install.</p>|' build/site/index.html

lint: build ## RTL lint, formatting, generated files, clang-tidy
	@$(call need,clang-tidy,dev )
	@tools/lint --all

format: ## format the C++ sources in place
	@$(call need,clang-format)
	@git ls-files '*.cpp' '*.hpp' | grep -v host/haptogram/format/interface.hpp | xargs clang-format -i

install: build ## install the program, the libraries and their headers (DESTDIR and CMAKE_INSTALL_PREFIX as usual)
	@cmake --install $(BUILD)

dist: ## wheel, .deb, source archive and bitstreams into build/dist; PARTS="wheel deb" only some
	@tools/dist $(PARTS)

# Each but the board's tools, which build nothing, ends in the picture of a heart. The wheel's seconds are those of pip alone. The demo's limit is
# 240 s: 180 s were the goal, but building the program alone takes so long on two processors.
HEART := compile tools/demo/heart.ply --size 40 --points 100 --rate 100 -o heart.hex
SEEN := field heart.hex --plane xy@z=130 -o heart.png && head -c 4 heart.png | grep -q PNG
fresh: ## the README's ways to begin, each on a bare Debian in a folder, with seconds and megabytes; ALL=1 every test there, too: needs root and debootstrap
	@tools/dist wheel deb; failed=$$?; \
	tools/fresh-machine --with "$$(ls build/dist/*.whl)" "" 'apt-get update -qq && apt-get install -qq -y --no-install-recommends python3-venv >/dev/null \
	  && /usr/bin/python3 -m venv haptic && time timeout 10 haptic/bin/pip install -q build/dist/*.whl && haptic/bin/haptogram $(HEART) && haptic/bin/haptogram $(SEEN)' || failed=1; \
	tools/fresh-machine --with "$$(ls build/dist/*.deb)" "" 'apt-get update -qq && apt-get install -qq -y ./build/dist/haptogram_*.deb >/dev/null && haptogram $(HEART) && haptogram $(SEEN)' || failed=1; \
	tools/fresh-machine "" "tools/setup board" || failed=1; \
	tools/fresh-machine --limit 240:250 "" "tools/setup demo && make demo && head -c 4 build/demo/heart/heart.png | grep -q PNG" || failed=1; \
	[ -z "$(ALL)" ] || tools/fresh-machine || failed=1; \
	exit $$failed

clean: ## remove everything that was built, but for the Python environment
	@find build -mindepth 1 -maxdepth 1 ! -name venv -exec rm -rf {} + 2>/dev/null || true
