# `make demo` and `make test` do all their own set-up; `make help` lists the targets.
PYTHON ?= python3
VENV := .venv
PIP := $(VENV)/bin/python -m pip --disable-pip-version-check --quiet
SOURCES := $(shell find host/core firmware/lib firmware/virtual -name '*.[ch]*') \
	pyproject.toml host/CMakeLists.txt
# Tests of a minute, for `make quick`; `make test` has them all.
QUICK := tests/test_structure.py tests/test_weight.py tests/firmware \
	$(addprefix tests/host/,base model lab servos)
# Four at a time: those of the robot mostly wait. A file's tests stay together, as they share what they made.
PYTEST := $(VENV)/bin/python -m pytest -n 4 --dist loadfile

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
	$(PYTEST) -m "not slow"

quick: $(VENV)/built $(VENV)/dev
	@$(MAKE) --no-print-directory --jobs=2 lint quick-tests

quick-tests:
	$(PYTEST) -q -m "not slow" $(QUICK)

test-slow: $(VENV)/built $(VENV)/dev
	@sh .ci/need chromium=chromium chromedriver=chromium-driver em++=emscripten node=nodejs \
		$$(cat tests/avr/packages.txt) || echo "what needs these is skipped"
	@sh .ci/need $$(cat tests/core/packages.txt) || echo "other compilers are skipped"
	$(PYTEST) -m slow

build: $(VENV)/built

lint: $(VENV)/built $(VENV)/dev
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
	$(VENV)/bin/serpenoid bench --out bench-out

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

.PHONY: help demo test quick quick-tests test-slow build lint format docs playground figures bench wheel lowest clean
