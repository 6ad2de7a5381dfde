# make report and make test are the two commands of the README; each makes .venv by itself.
SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help
.PHONY: help venv test report lint nightly bench lock clean

BIN := .venv/bin
STAMP := .venv/.installed
# What the nightly run compares with: a git revision or a folder.
BASELINE ?= HEAD~1
CANDIDATES := python3.12 python3.13 python3.14 python3 python

help:  ## this list
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*##/:/'

venv: $(STAMP)  ## make .venv with everything the lock file pins

# A candidate is run, not looked up: a pyenv shim may exist and fail.
$(STAMP): requirements.lock pyproject.toml
	@for candidate in $(CANDIDATES); do \
	  if "$$candidate" -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 12))' >/dev/null 2>&1; \
	  then python="$$candidate"; break; fi; \
	done; \
	if [ -z "$${python:-}" ]; then \
	  echo "mbs-ref needs Python 3.12 or newer with its venv module; none of $(CANDIDATES) is one here." >&2; exit 1; \
	fi; \
	if ! $(BIN)/python -c 'import sys, pip; sys.exit(sys.version_info < (3, 12))' >/dev/null 2>&1; then \
	  rm -rf .venv; "$$python" -m venv .venv; \
	fi
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	@touch $@

test: venv  ## the tests that finish in minutes
	$(BIN)/python -m pytest -n auto

report: venv  ## the main job: run the comparison and write reports/out/
	$(BIN)/mbs-ref report

lint: venv  ## ruff and pyright
	$(BIN)/ruff check .
	$(BIN)/pyright

# Every step runs, whatever became of those before; the exit code printed is that of the first that failed.
nightly: venv  ## the slow tests, the benchmarks, the full report, sweeps and the regression verdicts
	@mkdir -p reports/out; rm -f reports/out/bench.json reports/out/extremes.jsonl; failed=0; \
	step() { echo "== $$*"; "$$@" || { code=$$?; echo "exit code $$code: $$*" >&2; \
	  if [ $$failed -eq 0 ]; then failed=$$code; fi; }; }; \
	step $(BIN)/python -m pytest -n auto -m slow; \
	step $(BIN)/python -m pytest benchmarks -m '' --benchmark-only -p no:xdist --benchmark-json=reports/out/bench.json; \
	step $(BIN)/mbs-ref certify; \
	step $(BIN)/mbs-ref extremes --full -o reports/out/extremes.jsonl; \
	step $(BIN)/mbs-ref report; \
	bench=; if [ -s reports/out/bench.json ]; then bench="--bench reports/out/bench.json"; fi; \
	step $(BIN)/mbs-ref nightly --baseline $(BASELINE) $$bench --sweeps reports/out/sweeps --trends reports/out/trends.html; \
	exit $$failed

bench: venv  ## pytest-benchmark suites, alone on the machine
	$(BIN)/python -m pytest benchmarks -m '' --benchmark-only -p no:xdist

lock:  ## pin again what pyproject.toml asks for (needs uv)
	uv pip compile pyproject.toml --extra engines --extra cluster --extra dev --universal --python-version 3.12 \
	  --generate-hashes --no-emit-index-url --no-header --no-annotate --upgrade --quiet -o requirements.lock

clean:  ## remove everything that make made
	rm -rf .venv build dist *.egg-info reports/out .pytest_cache .ruff_cache .hypothesis .benchmarks
	find . -name __pycache__ -prune -exec rm -rf {} +
