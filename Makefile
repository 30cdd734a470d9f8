# `make demo` and `make test` do all their own set-up; every other target is one line.
PYTHON ?= python3
VENV := .venv
PIP := $(VENV)/bin/python -m pip --disable-pip-version-check --quiet
SOURCES := $(shell find host/core firmware/lib firmware/virtual -name '*.[ch]*') \
	pyproject.toml host/CMakeLists.txt

demo: $(VENV)/built
	$(VENV)/bin/serpenoid demo --out demo-out

test: $(VENV)/built $(VENV)/dev
	@sh .ci/need $$(cat tests/avr/packages.txt) || echo "without these the AVR tests are skipped"
	$(VENV)/bin/python -m pytest

build: $(VENV)/built

lint: $(VENV)/dev
	.ci/lint

clean:
	rm -rf build .pio demo-out $(VENV)

$(VENV)/bin/python:
	@sh .ci/need $(PYTHON)=python3 g++=g++
	@$(PYTHON) -c 'import ensurepip, venv' 2> /dev/null || sh .ci/need /absent=python3-venv
	@sh .ci/need $$($(PYTHON) -c 'import sysconfig; print(sysconfig.get_path("include"))')/Python.h=python3-dev
	$(PYTHON) -m venv $(VENV)

$(VENV)/run: constraints/run.txt | $(VENV)/bin/python
	@echo "installing the packages that serpenoid needs ..."
	@$(PIP) install --require-hashes --only-binary :all: -r $<
	@touch $@

$(VENV)/dev: constraints/dev.txt | $(VENV)/run
	@echo "installing the packages that the tests need ..."
	@$(PIP) install --require-hashes -r $<
	@touch $@

$(VENV)/built: $(SOURCES) | $(VENV)/run
	@echo "building the core (about a minute) ..."
	@PATH="$$PWD/$(VENV)/bin:$$PATH" $(PIP) install --no-build-isolation --no-deps --editable .
	@touch $@

.PHONY: demo test build lint clean
