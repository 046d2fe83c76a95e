# `make demo` and `make test` need git, make and python3 >= 3.11 alone; everything else is set up here.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
STAMP  := $(VENV)/.installed
LOCK   := requirements/dev.txt
# Tests start hundreds of processes. What these import is compiled once, also where the shell says not to.
export PYTHONDONTWRITEBYTECODE =

.PHONY: setup demo test test-all lint check docs docs-links bench lock release-check clean

setup: $(STAMP)

$(STAMP): $(LOCK) pyproject.toml
	@command -v $(PYTHON) >/dev/null || { echo "gsiirl: $(PYTHON) not found: install Python 3.11 or newer, or run make PYTHON=/path/to/python3"; exit 2; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "gsiirl: $(PYTHON) is too old: Python 3.11 or newer is needed (make PYTHON=/path/to/python3)"; exit 2; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { echo "gsiirl: this Python has no ensurepip: install the python3-venv package of your system"; exit 2; }
	@if command -v uv >/dev/null; then \
		uv venv --quiet --allow-existing --python "$$($(PYTHON) -c 'import sys; print(sys.executable)')" $(VENV) && \
		VIRTUAL_ENV=$(VENV) uv pip sync --quiet --require-hashes $(LOCK) && \
		VIRTUAL_ENV=$(VENV) uv pip install --quiet --no-deps --no-build-isolation --editable . ; \
	else \
		$(PYTHON) -m venv $(VENV) && \
		$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r $(LOCK) && \
		$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable . ; \
	fi
	@touch $(STAMP)

demo: $(STAMP)
	sh scripts/demo.sh $(BIN)/gsiirl

test: $(STAMP)
	$(BIN)/python -m pytest -n 2 --dist loadfile -m "not slow"

test-all: $(STAMP)
	$(BIN)/python -m pytest -n 2 --dist loadfile

lint: $(STAMP)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/basedpyright --project pyproject.toml

check: lint test

# Runs what the pages show, then builds the site. What ran before and has not changed is not run again.
docs: $(STAMP)
	$(BIN)/python scripts/run_pages.py
	$(BIN)/python -m sphinx --quiet --fresh-env --fail-on-warning --keep-going docs docs/_build/html
	@echo "Open docs/_build/html/index.html in a browser."

docs-links: $(STAMP)
	$(BIN)/python -m sphinx --quiet --keep-going -b linkcheck -D nb_execution_mode=off docs docs/_build/links

bench: $(STAMP)
	$(BIN)/python -m pytest benchmarks -s -o addopts="" -o pythonpath=benchmarks

lock:
	uv pip compile pyproject.toml --all-extras --group dev --universal --python-version 3.11 --generate-hashes --no-annotate --custom-compile-command "make lock" --output-file $(LOCK)

release-check: $(STAMP)
	sh scripts/release_check.sh

clean:
	rm -rf $(VENV) docs/_build .pytest_cache .ruff_cache .hypothesis .benchmarks
