# make demo: the embedded case from deck to report.  make test: the whole test suite.  Both install what they need.
PYTHON ?= python3
VENV ?= .venv
BIN = $(VENV)/bin
OUT ?= results

.PHONY: demo test lint bench clean

$(VENV)/.installed: pyproject.toml
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@$(BIN)/pip install --quiet --disable-pip-version-check -e .
	@touch $@

$(VENV)/.tested: $(VENV)/.installed
	@$(BIN)/pip install --quiet --disable-pip-version-check -e ".[test]"
	@touch $@

demo: $(VENV)/.installed
	$(BIN)/fowtio run validation/oc4_deepcwind/oc4.fowt -o $(OUT)/oc4

test: $(VENV)/.tested
	$(BIN)/ruff check .
	$(BIN)/lint-imports
	$(BIN)/pytest -n 2

bench: $(VENV)/.tested
	$(BIN)/python benchmarks/bench_main_job.py

clean:
	rm -rf $(VENV) $(OUT)
