# make report and make test are the two commands of the README; each makes .venv by itself.
SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help
.PHONY: help venv kernels test report lint nightly mutants bench site pictures lock clean

# Every worker and child process would compile all modules again.
unexport PYTHONDONTWRITEBYTECODE

BIN := .venv/bin
STAMP := .venv/.installed
# The nightly run's own environment: JPL's ephemerides, LSODAR and every optional engine besides, so that nothing is
# skipped for good.
NIGHT := .venv-nightly/bin
NIGHT_STAMP := .venv-nightly/.installed
# Where the documentation is built, and its notebooks are run.
DOCS := .venv-docs/bin
DOCS_STAMP := .venv-docs/.installed
# What the nightly run compares with: a git revision or a folder.
BASELINE ?= HEAD~1
# How long the nightly run begins new seeded defects; the next night goes on from there.
MUTANT_MINUTES ?= 30
# Which part of the full extremes is driven: one of seven, another each night, so that a week sees them all.
EXTREME_PART ?= $(shell echo $$(($$(date +%s) / 86400 % 7 + 1)))
NIGHT_EXTREMES := reports/out/extremes-$(EXTREME_PART).jsonl
CANDIDATES := python3.12 python3.13 python3.14 python3 python

help:  ## this list
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*##/:/'

venv: $(STAMP)  ## make .venv with everything the lock file pins

# $(1) the environment's folder, $(2) its lock file.
# A candidate is run, not looked up: a pyenv shim may exist and fail.
define install
	@for candidate in $(CANDIDATES); do \
	  if "$$candidate" -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 12))' >/dev/null 2>&1; \
	  then python="$$candidate"; break; fi; \
	done; \
	if [ -z "$${python:-}" ]; then \
	  echo "mbs-ref needs Python 3.12 or newer with its venv module; none of $(CANDIDATES) is one here." >&2; exit 1; \
	fi; \
	if ! $(1)/bin/python -c 'import sys, pip; sys.exit(sys.version_info < (3, 12))' >/dev/null 2>&1; then \
	  rm -rf $(1); "$$python" -m venv $(1); \
	fi
	$(1)/bin/python -m pip install --quiet --disable-pip-version-check --require-hashes -r $(2)
	$(1)/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	@touch $(1)/.installed
endef

$(STAMP): requirements.lock pyproject.toml
	$(call install,.venv,requirements.lock)

$(NIGHT_STAMP): requirements-nightly.lock pyproject.toml
	$(call install,.venv-nightly,requirements-nightly.lock)

$(DOCS_STAMP): requirements-docs.lock pyproject.toml
	$(call install,.venv-docs,requirements-docs.lock)

kernels: venv  ## the solver's compiled code, made once for each change of its sources
	@$(BIN)/mbs-ref compile

test: kernels  ## the tests that finish in minutes
	$(BIN)/python -m pytest -n auto --dist worksteal -rs

report: venv  ## the main job: run the comparison and write reports/out/
	$(BIN)/mbs-ref report

lint: venv  ## ruff's rules and layout, and pyright
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright

# Every step runs, whatever became of those before; the exit code printed is that of the first that failed. A night that
# was cut short goes on at the step it was in: steps that ended leave their exit code behind, for this revision.
REVISION := $(shell git rev-parse --short HEAD 2>/dev/null || echo unknown)
# The runs that the tests made serve the report and the sweeps, and the next night where its code is the same.
NIGHT_STORE := reports/out/nightly.sqlite
NIGHT_MARKS := reports/out/nightly-$(REVISION)
nightly: $(NIGHT_STAMP)  ## all tests, seeded defects, the benchmarks, the full report, sweeps and the regression verdicts
	@if [ ! -d $(NIGHT_MARKS) ]; then \
	  rm -rf reports/out/nightly-* reports/out/bench.json $(NIGHT_EXTREMES); mkdir -p $(NIGHT_MARKS); fi; \
	failed=0; number=0; \
	step() { number=$$((number + 1)); mark=$(NIGHT_MARKS)/$$number; \
	  if [ -f $$mark ]; then echo "== before: $$*"; else \
	    echo "== $$(date +%H:%M) $$*"; code=0; "$$@" || code=$$?; echo $$code > $$mark; fi; \
	  code=$$(cat $$mark); if [ $$code -ne 0 ]; then echo "exit code $$code: $$*" >&2; \
	    if [ $$failed -eq 0 ]; then failed=$$code; fi; fi; }; \
	step env MBS_REF_TEST_STORE=$(NIGHT_STORE) $(NIGHT)/python -m pytest -n auto --dist worksteal -rs -m '' --hypothesis-profile=default; \
	step $(NIGHT)/python -m tests.cross_checks.truths.covering --part $(EXTREME_PART)/7; \
	step $(NIGHT)/python -m tests.mutants.run --slow --minutes $(MUTANT_MINUTES); \
	step $(NIGHT)/python -m pytest benchmarks -m '' --benchmark-only -p no:xdist --benchmark-json=reports/out/bench.json; \
	step $(NIGHT)/mbs-ref certify; \
	step $(NIGHT)/mbs-ref proofs --seed $$(($$(date +%s) / 86400)) --shard $(EXTREME_PART)/7; \
	step sh -c '$(NIGHT)/mbs-ref proofs --again --shard $(EXTREME_PART)/7 || test $$? -eq 5'; \
	step $(NIGHT)/mbs-ref extremes --full --shard $(EXTREME_PART)/7 -o $(NIGHT_EXTREMES); \
	step env MBS_REF_STORE=$(NIGHT_STORE) $(NIGHT)/mbs-ref report --full; \
	bench=; if [ -s reports/out/bench.json ]; then bench="--bench reports/out/bench.json"; fi; \
	step env MBS_REF_STORE=$(NIGHT_STORE) $(NIGHT)/mbs-ref nightly --baseline $(BASELINE) $$bench --sweeps reports/out/sweeps --trends reports/out/trends.html; \
	step $(NIGHT)/mbs-ref board -o reports/out/board.html; \
	rm -rf $(NIGHT_MARKS); \
	exit $$failed

mutants: venv  ## seeded defects: does every one fail a test? goes on where it stopped
	$(BIN)/python -m tests.mutants.run

bench: venv  ## pytest-benchmark suites, alone on the machine
	$(BIN)/python -m pytest benchmarks -m '' --benchmark-only -p no:xdist

site: venv $(DOCS_STAMP)  ## the documentation with the gallery, in build/site; a warning or a broken link is an error
	$(BIN)/python -m reports.site build/site-src
	$(DOCS)/python -m reports.site.notebooks build/site-src
	NO_MKDOCS_2_WARNING=1 $(DOCS)/mkdocs build --strict --quiet
	$(BIN)/python -m reports.site.links build/site
	@echo "build/site/index.html; its search needs a server: python -m http.server -d build/site"

pictures: venv  ## the README's pictures, from the last report; needs Chromium
	$(BIN)/python -m reports.site.pictures

PINNED := --universal --python-version 3.12 --generate-hashes --no-emit-index-url --no-header --no-annotate --quiet
EXTRAS := --extra engines --extra cluster --extra proofs --extra dev
NIGHTLY := --extra ephemeris --extra lsodar --extra heyoka --extra drake --extra dart --extra mjx --extra opensim --extra notebooks \
  --extra polars --extra film --extra parquet --extra robots
SITE := --extra docs --extra engines --extra notebooks

lock:  ## pin again what pyproject.toml asks for (needs uv)
	uv pip compile pyproject.toml $(EXTRAS) $(PINNED) --upgrade -o requirements.lock
	uv pip compile pyproject.toml $(EXTRAS) $(NIGHTLY) $(PINNED) --upgrade \
	  -c requirements.lock -o requirements-nightly.lock
	uv pip compile pyproject.toml $(SITE) $(PINNED) --upgrade -c requirements.lock -o requirements-docs.lock

clean:  ## remove everything that make made
	rm -rf .venv .venv-nightly .venv-docs build dist *.egg-info reports/out .pytest_cache .ruff_cache .hypothesis .benchmarks
	find . -name __pycache__ -prune -exec rm -rf {} +
