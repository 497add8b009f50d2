# Two commands do everything on a machine with Python 3.11+, pip, venv and make:
#   make demo    create .venv, install, run the PN self-test of a MEMS accelerometer, write its report
#   make test    create .venv, install, run the tests
# make test-all runs the exhaustive tests too; make test-fast those that compile nothing: the loop of a developer.
# PYTHON names another interpreter, VENV another folder for the environment, WORKERS how many processes run tests.

PYTHON ?= python3
VENV ?= .venv
WORKERS ?= $(shell nproc)
BIN = $(VENV)/bin

.PHONY: demo test test-all test-fast defects derivations friendliness coverage mutants lint docs pictures benchmark clean

demo: $(VENV)/installed
	$(BIN)/python -m benchmarks.self_test demo

test: $(VENV)/installed-test
	$(BIN)/python -m pytest --numprocesses $(WORKERS) --dist worksteal

test-all: $(VENV)/installed-test
	$(BIN)/python -m pytest --numprocesses $(WORKERS) --dist worksteal --exhaustive

FAST = tests/blocks/declaration tests/graphs tests/runner/commands/declarations tests/test_imports.py \
	$(addprefix tests/documents/test_,ci.py claims.py decisions.py english.py stubs.py) \
	--ignore tests/graphs/model/test_nesting.py

test-fast: $(VENV)/installed-test
	$(BIN)/python -m pytest --numprocesses $(WORKERS) --dist worksteal $(FAST)

# What was once silently wrong (S), hung (H) or crashed (C): test, before, after, outcome.
defects: $(VENV)/installed-test
	$(BIN)/python -m pytest -m defect --defects --exhaustive

# What each block of physics was compared with, by a second person: equation, source, convention, what was wrong.
derivations: $(VENV)/installed-test
	$(BIN)/python -m pytest tests/blocks -m derivation --derivations

# What a person does and expects, in 42 rows: the tests that show each, its points, and their sum.
friendliness: $(VENV)/installed-test
	$(BIN)/python -m pytest -m friendly --friendliness

# Which branches of the source some test takes, by room; what none takes has its reason. Twice the time of all tests.
coverage: $(VENV)/installed-test
	$(BIN)/python -m tests.coverage --exhaustive

# 300 small changes of the source, each against the tests that pass its line, as `python -m tests.coverage --by-test` has measured them.
mutants: $(VENV)/installed-test
	$(BIN)/python -m tests.mutants --count 300

lint: $(VENV)/installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/pyright --pythonpath $(BIN)/python
	$(BIN)/lint-imports
	@if command -v tsc > /dev/null; then tsc -p runner/live; \
	else echo "skipped: types of the scripts of live pages, for want of tsc (npm install -g typescript)"; fi

# The site, without warnings, into build/site/html; it needs no network to be read.
docs: $(VENV)/installed-docs
	$(BIN)/python -m docs.site

# Every picture of the documents, drawn again; some minutes.
pictures: $(VENV)/installed
	$(BIN)/python -m docs.site.pictures

benchmark: $(VENV)/installed
	$(BIN)/python benchmarks/compare_with_c.py
	$(BIN)/python benchmarks/monte_carlo.py
	$(BIN)/python benchmarks/library.py
	$(BIN)/python benchmarks/many_runs.py
	$(BIN)/python benchmarks/startup.py
	$(BIN)/python benchmarks/memory.py
	$(BIN)/python benchmarks/normal_deviates.py
	$(BIN)/python benchmarks/peers.py

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/installed: $(VENV)/bin/python pyproject.toml
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[all]"
	touch $@

$(VENV)/installed-test: $(VENV)/installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[test]"
	touch $@

$(VENV)/installed-dev: $(VENV)/installed-test
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[dev]"
	touch $@

$(VENV)/installed-docs: $(VENV)/installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[docs]"
	touch $@

clean:
	rm -rf $(VENV) demo build dist
