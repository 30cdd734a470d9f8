# `make demo` and `make test` do all their own set-up; `make help` lists the targets.
PYTHON ?= python3
VENV := .venv
PIP := $(VENV)/bin/python -m pip --disable-pip-version-check --quiet
SOURCES := $(shell find host/core firmware/lib firmware/virtual -name '*.[ch]*') \
	pyproject.toml host/CMakeLists.txt
# What takes long beside what it finds before a commit; `make test` has it all.
LONG := $(addprefix tests/,avr docs end_to_end firmware oracle golden studies) \
	$(addprefix tests/host/,bench commands gaits model/test_stubs.py periodic robot show video) \
	$(addprefix tests/host/simulation/test_,adaptive.py nonsmooth.py positive_work.py \
	radau.py ratchet.py run_error.py stability.py steady_springs.py truths.py) \
	tests/host/servos/test_measured.py \
	$(addprefix tests/host/calibration/test_,balanced_bends.py crawls_fit.py dialogue.py \
	dialogue_fuzz.py filmed_crawls.py floor_fit.py floor_tracks.py friction.py honest_fit.py page.py \
	procedure.py ratchet_fit.py ratchet_procedure.py rounding.py shared_errors.py short_readings.py) \
	$(addprefix tests/host/prediction/test_,advice.py comparison.py prediction.py speed_doubts.py)

# Modules are compiled once, not anew in each of the hundred processes that tests start.
unexport PYTHONDONTWRITEBYTECODE
# Matrices are small: threads of BLAS only wait for each other (a quarter of the time of crawl fits).
export OPENBLAS_NUM_THREADS := 1

help:
	@echo "make demo       from the 2005 treadmill to a predicted speed; no robot needed"
	@echo "make test       every test but the slow ones (some minutes)"
	@echo "make quick      lint, and the tests of a minute: before each commit"
	@echo "make lint       style and types"
	@echo "make test-slow  the long studies"
	@echo "make format     settle the style of Python and C++"
	@echo "make playground one page to try gaits in a browser: build/playground/index.html"
	@echo "make docs       the documentation site, into build/docs/html"
	@echo "make figures    draw the stored figures anew"
	@echo "make bench      measure again what docs/benchmarks.md quotes"
	@echo "make wheel      wheel and sdist, into dist/"

demo: $(VENV)/built
	$(VENV)/bin/serpenoid demo --out demo-out

test: $(VENV)/built $(VENV)/dev
	@sh .ci/need chromium=chromium chromedriver=chromium-driver node=nodejs \
		$$(cat tests/avr/packages.txt) \
		|| echo "what needs these is skipped"
	@$(MAKE) --no-print-directory --jobs=4 test-robot test-session test-numbers \
		test-host test-board test-faces

# The parts of `make test`, four beside each other (that of the robot waits most of its time); each
# line says whose it is.
PART = @.ci/part $@ $(VENV)/bin/python -m pytest
NUMBERS = $(addprefix tests/host/,model periodic simulation gaits)
SESSION = $(addprefix tests/host/,calibration prediction)
HOST = tests/host tests/end_to_end
GAITS = tests/host/gaits
ROBOT = tests/host/robot
FACES = tests/host/show tests/host/video
test-host:
	$(PART) -m "not slow" $(HOST) $(addprefix --ignore=,$(NUMBERS) $(SESSION) $(ROBOT) $(FACES))

test-faces:
	$(PART) -m "not slow" $(FACES)

test-session:
	$(PART) -m "not slow" $(SESSION)

test-robot:
	$(PART) -m "not slow" $(ROBOT)

test-numbers:
	$(PART) -m "not slow" $(NUMBERS)

test-board:
	$(PART) -m "not slow" $(addprefix --ignore=,$(HOST))

quick: $(VENV)/built $(VENV)/dev
	@$(MAKE) --no-print-directory --jobs=2 lint quick-tests

quick-tests:
	$(PART) -q -m "not slow" $(addprefix --ignore=,$(LONG))

test-slow: $(VENV)/built $(VENV)/dev
	@sh .ci/need chromium=chromium chromedriver=chromium-driver em++=emscripten node=nodejs \
		$$(cat tests/avr/packages.txt tests/arm/packages.txt) || echo "what needs these is skipped"
	@sh .ci/need $$(cat tests/portable/packages.txt) || echo "other compilers are skipped"
	@$(MAKE) --no-print-directory --jobs=3 slow-host slow-board slow-docs \
		slow-gaits

slow-host:
	$(PART) -m slow $(HOST) --ignore=$(GAITS)

slow-gaits:
	$(PART) -m slow $(GAITS)

slow-board:
	$(PART) -m slow $(addprefix --ignore=,$(HOST) tests/docs)

slow-docs:
	$(PART) -m slow tests/docs

build: $(VENV)/built

lint: $(VENV)/dev
	.ci/lint

format: $(VENV)/dev
	.ci/format

docs: $(VENV)/built $(VENV)/docs
	@sh .ci/need em++=emscripten || echo "the documentation is built without its playground"
	.ci/docs

playground: $(VENV)/built
	@sh .ci/need em++=emscripten
	$(VENV)/bin/python docs/build_playground.py build/playground --alone
	@echo "open build/playground/index.html in a browser"

figures: $(VENV)/built
	$(VENV)/bin/python docs/figures.py

bench: $(VENV)/built
	$(VENV)/bin/serpenoid bench accuracy --out bench-out
	$(VENV)/bin/serpenoid bench scenes --out bench-out

wheel: $(VENV)/built $(VENV)/dev
	.ci/wheel

lowest:
	.ci/lowest

clean:
	rm -rf build dist .pio demo-out bench-out $(VENV)

$(VENV)/bin/python:
	@sh .ci/need $(PYTHON)=python3 g++=g++
	@$(PYTHON) -c 'import ensurepip, venv' 2> /dev/null || sh .ci/need /absent=python3-venv
	@sh .ci/need $$($(PYTHON) -c 'import sysconfig; print(sysconfig.get_path("include"))')/Python.h=python3-dev
	$(PYTHON) -m venv $(VENV)

$(VENV)/build: constraints/build.txt | $(VENV)/bin/python
	@echo "installing what the build needs ..."
	@$(PIP) install --require-hashes --only-binary :all: -r $<
	@touch $@

$(VENV)/run: constraints/run.txt | $(VENV)/build
	@echo "installing the packages that serpenoid needs ..."
	@$(PIP) install --require-hashes --only-binary :all: -r $<
	@touch $@

$(VENV)/dev $(VENV)/docs: $(VENV)/%: constraints/%.txt | $(VENV)/run
	@echo "installing the packages for $* ..."
	@$(PIP) install --require-hashes -r $<
	@touch $@

$(VENV)/core: $(SOURCES) | $(VENV)/build
	@echo "building the core (some twenty seconds) ..."
	@PATH="$$PWD/$(VENV)/bin:$$PATH" $(PIP) install --no-build-isolation --no-deps --editable .
	@touch $@

# The packages are installed beside the compiler's work.
$(VENV)/built: $(SOURCES) constraints/run.txt
	@$(MAKE) --no-print-directory --jobs=2 $(VENV)/core $(VENV)/run
	@touch $@

.PHONY: help demo test test-host test-faces test-robot test-session test-numbers test-board quick quick-tests test-slow slow-host slow-board slow-docs slow-gaits build lint format docs playground figures bench wheel lowest clean
