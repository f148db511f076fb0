# The commands of this project; `make` alone lists them. Everything is set up in virtual environments of the
# project's own (.venv, .venv-newest, .venv-bench), from cargo, make, git and a Python 3.11.
# Holds no logic of the tests or of the build: those are in cargo, maturin, pytest and blender_scripts.

PYTHON ?= python3.11
# The newest Blender runs on Python 3.13: used by the add-on's tests where such an interpreter is found.
PYTHON_NEWEST ?= $(shell for p in python3.13 $(HOME)/.pyenv/versions/3.13*/bin/python3.13; do \
    $$p -c '' 2>/dev/null && { echo $$p; break; }; done)

VENV := .venv
NEWEST := .venv-newest
RELEASE := .venv-release
BENCH := .venv-bench
# What the benchmark compares with and draws with, beside what requirements-dev.txt has; what cannot be had is left out.
BENCH_PEERS := matplotlib==3.11.2 meshlib==3.1.4.297 libigl==2.6.3
BIN := $(VENV)/bin
WHEELS := dist/wheels
RELEASE_WHEELS := dist/release-wheels
# The wheel that is shipped runs on every Linux since 2014; elsewhere the system's own compiler does.
RELEASE_OPTIONS := $(if $(filter Linux,$(shell uname -s)),--zig --compatibility manylinux2014)
# The scan that the picture of a net shows; not a part of the project.
NET_MESH ?= $(or $(SMOOTH_POLYLINES_MESHES),../shared/meshes)/igea.ply
STEP = @printf '\n=== %s\n'

RUST_SOURCES := $(shell find rust -type f -not -path '*/target/*' -not -name '*.pyc' -not -name '*.so' 2>/dev/null)
WHEEL_INPUTS := $(RUST_SOURCES) Cargo.toml Cargo.lock pyproject.toml README.md

export PIP_DISABLE_PIP_VERSION_CHECK := 1
# A developer's own Blender start-up scripts have no business in here.
unexport BLENDER_USER_SCRIPTS BLENDER_SYSTEM_SCRIPTS

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help setup dev demo images images-gui example test test-rust test-native test-addon test-batch test-newest test-package \
    test-render test-gui test-batch-large test-package-all bench hostile fuzz huge figures fmt lint wheel release-wheel extension repository clean

help: ## list the commands
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-18s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

# --- setting up -------------------------------------------------------------------------------------------

setup: $(VENV)/.requirements.stamp ## make the virtual environment and install the pinned tools and Blender (bpy)

$(VENV)/.requirements.stamp: requirements-dev.txt
	$(STEP) "Setting up $(VENV) (downloads Blender once, about 400 MB)"
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' || \
	    { echo "$(PYTHON) is not a Python 3.11, which bpy 4.2 needs; say where it is: make PYTHON=/path/to/python3.11"; exit 1; }
	@$(PYTHON) -m venv $(VENV) || { echo "Python's venv module is missing (Debian: apt-get install python3.11-venv)"; exit 1; }
	$(BIN)/pip install --only-binary :all: -r requirements-dev.txt
	@$(BIN)/python blender_scripts/check_blender.py
	@touch $@

$(NEWEST)/.requirements.stamp: requirements-dev.txt
	$(STEP) "Setting up $(NEWEST) for the newest Blender (downloads about 400 MB)"
	@$(PYTHON_NEWEST) -m venv $(NEWEST)
	$(NEWEST)/bin/pip install --only-binary :all: -r requirements-dev.txt
	@$(NEWEST)/bin/python blender_scripts/check_blender.py
	@touch $@

$(RELEASE)/.requirements.stamp: requirements-release.txt
	$(STEP) "Setting up $(RELEASE) for the wheel that is shipped (downloads about 90 MB)"
	@$(PYTHON) -m venv $(RELEASE)
	$(RELEASE)/bin/pip install --quiet --only-binary :all: -r requirements-release.txt
	@touch $@

$(BENCH)/.requirements.stamp: requirements-dev.txt Makefile
	$(STEP) "Setting up $(BENCH) with the libraries that the benchmark compares with"
	@$(PYTHON) -m venv $(BENCH)
	$(BENCH)/bin/pip install --only-binary :all: -c requirements-dev.txt numpy scipy potpourri3d pygeodesic pytest
	@for peer in $(BENCH_PEERS); do \
	    $(BENCH)/bin/pip install --only-binary :all: -c requirements-dev.txt $$peer || echo "no $$peer here: left out"; \
	done
	@touch $@

# --- building ---------------------------------------------------------------------------------------------

wheel: $(WHEELS)/.built.stamp ## build the library's wheel into dist/wheels

$(WHEELS)/.built.stamp: $(VENV)/.requirements.stamp $(WHEEL_INPUTS)
	$(STEP) "Building the wheel"
	@rm -rf $(WHEELS)
	$(BIN)/maturin build --release --interpreter $(BIN)/python --out $(WHEELS)
	@touch $@

dev: $(VENV)/.wheel.stamp ## build the wheel and install it into the virtual environment

$(VENV)/.wheel.stamp: $(WHEELS)/.built.stamp
	$(BIN)/pip install --quiet --force-reinstall --no-deps --no-index $(WHEELS)/*.whl
	@touch $@

$(NEWEST)/.wheel.stamp: $(NEWEST)/.requirements.stamp $(WHEELS)/.built.stamp
	$(NEWEST)/bin/pip install --quiet --force-reinstall --no-deps --no-index $(WHEELS)/*.whl
	@touch $@

release-wheel: $(RELEASE_WHEELS)/.built.stamp ## build the wheel that is shipped, for old systems too, and audit it

$(RELEASE_WHEELS)/.built.stamp: $(RELEASE)/.requirements.stamp $(WHEEL_INPUTS)
	$(STEP) "Building the wheel that is shipped"
	@rm -rf $(RELEASE_WHEELS)
	PATH="$(CURDIR)/$(RELEASE)/bin:$$PATH" $(RELEASE)/bin/maturin build --release --interpreter $(RELEASE)/bin/python \
	    $(RELEASE_OPTIONS) --out $(RELEASE_WHEELS)
	$(RELEASE)/bin/abi3audit --strict --verbose $(RELEASE_WHEELS)/*.whl
	@touch $@

extension: $(RELEASE_WHEELS)/.built.stamp $(VENV)/.requirements.stamp ## build, audit and validate the Blender extension (zip) for this platform, into dist/
	$(STEP) "Building the extension"
	$(BIN)/python blender_scripts/build_extension.py --wheels $(RELEASE_WHEELS) --output dist

repository: extension ## a folder to put on a web server: Blender installs and updates the extension from there (dist/repository)
	$(STEP) "Building the extension repository"
	$(BIN)/python blender_scripts/build_repository.py --zips dist --output dist/repository

# --- trying it --------------------------------------------------------------------------------------------

demo: $(VENV)/.wheel.stamp ## a line on Suzanne in real Blender: out/demo.blend, out/demo.png (MESH=path for your own mesh)
	$(STEP) "Running the demo in Blender"
	$(BIN)/python blender_scripts/demo.py --output out $(if $(MESH),--mesh "$(MESH)")

images: $(VENV)/.wheel.stamp ## make the pictures of the README and the docs again, into docs/images
	$(STEP) "Making the pictures"
	$(BIN)/python blender_scripts/demo.py --output out/images --width 960
	$(BIN)/python blender_scripts/demo.py --output out/images/fair --filter fair --width 960
	@mkdir -p docs/images && cp out/images/demo.png docs/images/suzanne.png && cp out/images/fair/demo.png docs/images/fair.png
	$(BIN)/python blender_scripts/seam_pictures.py --output docs/images
	$(if $(wildcard $(NET_MESH)),$(BIN)/python blender_scripts/net_picture.py --mesh $(NET_MESH) --output docs/images,@echo "NOT MADE: docs/images/net.png, which needs the test mesh $(NET_MESH)")

example: $(VENV)/.wheel.stamp ## the example with PyVista: docs/images/pyvista.png (downloads about 150 MB the first time)
	@[ -e .venv-plot/.stamp ] || { $(PYTHON) -m venv .venv-plot && \
	    .venv-plot/bin/pip install --quiet --only-binary :all: pyvista==0.49.1 vtk==9.7.2 && touch .venv-plot/.stamp; }
	.venv-plot/bin/pip install --quiet --force-reinstall --no-deps --no-index $(WHEELS)/*.whl
	.venv-plot/bin/python examples/pyvista_line.py docs/images/pyvista.png

# --- checking ---------------------------------------------------------------------------------------------

test: test-rust test-native test-addon test-batch test-package test-render test-newest test-gui ## every test, Rust and Python, in real Blender where it matters
	$(STEP) "All tests passed"

test-rust: ## tests of the Rust workspace
	$(STEP) "Rust tests"
	cargo test --locked --workspace

test-native: $(VENV)/.wheel.stamp ## tests of the wheel, with numpy alone
	$(STEP) "Tests of the wheel"
	$(BIN)/python -m pytest tests/native

test-addon: $(VENV)/.wheel.stamp ## tests of the add-on, in the oldest Blender that we support
	$(STEP) "Tests of the add-on"
	$(BIN)/python -m pytest tests/addon

test-batch: $(VENV)/.wheel.stamp ## tests of the batch: runs killed, crashed, out of room, on clusters; bad jobs; every kind of input
	$(STEP) "Tests of the batch"
	$(BIN)/python -m pytest tests/batch

test-batch-large: $(VENV)/.wheel.stamp ## 200 files with 10 broken ones, killed in the middle and started again: byte-equal (some minutes; not in make test)
	$(STEP) "The big batch"
	SMOOTH_POLYLINES_LARGE=1 $(BIN)/python -m pytest tests/batch/test_large.py

test-package: $(VENV)/.wheel.stamp extension ## the rules; the extension that is shipped: built, audited, validated, installed in Blenders, run
	$(STEP) "Tests of the rules and of the extension package"
	$(BIN)/python -m pytest tests/rules tests/package

# Each is a download of 374 MB and 15 seconds to install.
test-package-all: test-package ## the same in the Blenders between the oldest and the newest, too: 4.5 and 5.0
	@for version in 4.5.15 5.0.1; do \
	    folder=.venv-blender-$$version; \
	    [ -e $$folder/.stamp ] || { $(PYTHON) -m venv $$folder && \
	        $$folder/bin/pip install --quiet --only-binary :all: bpy==$$version numpy==1.26.4 pytest && touch $$folder/.stamp; } && \
	    printf '\n=== Blender %s\n' $$version && $$folder/bin/python -m pytest tests/package/test_installs.py || exit 1; \
	done

test-render: $(VENV)/.wheel.stamp ## the demo, with small pictures that are looked at
	$(STEP) "Tests of the demo and its pictures"
	$(BIN)/python -m pytest tests/render

ifeq ($(PYTHON_NEWEST),)
test-newest:
	$(STEP) "NOT RUN: the add-on's tests in the newest Blender: no Python 3.13 found (PYTHON_NEWEST=/path/to/python3.13)"
else
test-newest: $(NEWEST)/.wheel.stamp extension ## tests of the wheel, the add-on and the package, in the newest Blender (Python 3.13)
	$(STEP) "The same tests in the newest Blender"
	$(NEWEST)/bin/python -m pytest tests/native
	$(NEWEST)/bin/python -m pytest tests/addon
	$(NEWEST)/bin/python -m pytest tests/package -k 'not blender_program and not started_with'
endif

# Where a Blender with a window can be unpacked from Debian's packages: as root, on Debian.
CAN_UNPACK := $(shell [ "$$(id -u)" = 0 ] && command -v apt-get dpkg-deb chroot >/dev/null && echo yes)

.blender/%/.complete: blender_scripts/get_blender.sh
	$(STEP) "Unpacking Blender from Debian $* into .blender/$* (about 320 MB, half a minute)"
	@blender_scripts/get_blender.sh .blender/$* $*
	@touch $@

test-gui: extension ## the draw tool in real windows: Debian's Blenders, or BLENDER=/path/to/your/blender
ifdef BLENDER
	$(STEP) "Tests in the window of $(BLENDER)"
	BLENDER="$(BLENDER)" $(BIN)/python -m pytest tests/gui
else ifeq ($(CAN_UNPACK),)
	$(STEP) "NOT RUN: the tests in a real window: this needs root on Debian, or BLENDER=/path/to/blender"
else
	@$(MAKE) --no-print-directory .blender/trixie/.complete
	@$(MAKE) --no-print-directory .blender/sid/.complete || printf '\n=== %s\n' "NOT RUN: the window tests in the newest Blender, which could not be unpacked"
	$(STEP) "Tests in a real window"
	$(BIN)/python -m pytest tests/gui
endif

images-gui: test-gui ## the docs' pictures of the draw tool, from the window tests
	blender_scripts/copy_window_pictures.sh

# --- measuring --------------------------------------------------------------------------------------------

bench: $(BENCH)/.requirements.stamp $(WHEELS)/.built.stamp ## us and other libraries on the same queries, into docs/benchmarks.md (QUICK=1: small meshes, into out/bench)
	$(BENCH)/bin/pip install --quiet --force-reinstall --no-deps --no-index $(WHEELS)/*.whl
ifdef QUICK
	$(STEP) "Benchmarks, quick"
	PYTHONPATH=tests $(BENCH)/bin/python -m bench --size quick --output out/bench --page out/bench/benchmarks.md --images out/bench
else
	$(STEP) "Benchmarks of the parts"
	cargo bench --locked -p smooth-polylines-core --bench parts
	$(STEP) "Benchmarks beside other libraries"
	PYTHONPATH=tests $(BENCH)/bin/python -m bench --output out/bench --page docs/benchmarks.md --images docs/images \
	    --criterion $(or $(CARGO_TARGET_DIR),target)/criterion
endif

hostile: $(VENV)/.wheel.stamp ## every filter on 518 meshes that could hurt it, judged line by line; writes docs/hostile.md
	$(STEP) "Hostile meshes"
	PYTHONPATH=tests $(BIN)/python -m hostile --output out/hostile --page docs/hostile.md --processes $(or $(PROCESSES),1)

huge: $(VENV)/.wheel.stamp ## ten million triangles opened, and a line across: time and memory
	$(STEP) "Ten million triangles"
	PYTHONPATH=tests $(BIN)/python -m huge

# Needs cargo-fuzz (cargo install cargo-fuzz). The compiler is the ordinary one, told that it may instrument.
fuzz: ## fuzz meshes, lines and bytes for FUZZ_SECONDS each (600), finds in rust/fuzz/artifacts
	@command -v cargo-fuzz >/dev/null || { echo "cargo-fuzz is missing: cargo install cargo-fuzz"; exit 1; }
	$(STEP) "Fuzzing, $(or $(FUZZ_SECONDS),600) s for each target"
	@cd rust/fuzz && for target in mesh line bytes; do \
	    RUSTC_BOOTSTRAP=1 cargo fuzz run --fuzz-dir . -s $(or $(SANITIZER),none) $$target -- \
	        -max_total_time=$(or $(FUZZ_SECONDS),600) -timeout=20 -max_len=900 -print_final_stats=1 || exit 1; \
	done

figures: $(VENV)/.wheel.stamp ## the paper's figures redone on real meshes, into docs/images and docs/figures.md
	$(STEP) "Drawing the paper's figures"
	$(BIN)/python blender_scripts/figures.py --images docs/images --page docs/figures.md

fmt: $(VENV)/.requirements.stamp ## format Rust and Python
	cargo fmt --all
	$(BIN)/ruff check --fix --select I .
	$(BIN)/ruff format .

lint: $(VENV)/.requirements.stamp ## formats, clippy, rustdoc, ruff: no change, no warning
	$(STEP) "Lint"
	cargo fmt --all --check
	cargo clippy --locked --workspace --all-targets -- -D warnings
	RUSTDOCFLAGS='-D warnings' cargo doc --locked --workspace --no-deps --document-private-items
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

clean: ## remove everything that was built, and the virtual environments
	cargo clean
	rm -rf $(VENV) $(NEWEST) $(RELEASE) $(BENCH) .venv-plot .venv-blender-* .blender dist out .pytest_cache .ruff_cache
