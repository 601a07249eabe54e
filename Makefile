# make report   set up .venv and write the stability report of the published fly
# make reports  regenerate every committed example under reports/ but coverage and bench, the analyses by flycontrol validate
# make coverage how often intervals hold the truth, 20,000 fits: ten minutes on two cores; goes on where it was
# make test     set up .venv and run the fast tests
# make test-all one pytest run, the slow tests included
# make fuzz     100,000 malformed files for each reader of text, 20,000 for each of binary files; half an hour or more
# make check    lint, format, types, layers, spelling
# make bench    speed against named peers, as ratios in one run

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt

export NUMBA_CACHE_DIR := $(CURDIR)/.cache/numba
export MPLCONFIGDIR := $(CURDIR)/.cache/matplotlib
export PIP_CACHE_DIR := $(CURDIR)/.cache/pip

.PHONY: report reports coverage test test-all fuzz check format bench clean

report: $(VENV)/run.stamp
	$(BIN)/flycontrol report --out reports/yaw

DATA := $(or $(FLYCONTROL_DATA),../shared/data)
FLIGHTS := $(notdir $(basename $(wildcard $(DATA)/muijres_freeflight/2*.txt)))

reports: report
	$(BIN)/flycontrol validate --out reports/validation --reports reports || [ $$? -eq 1 ]
	$(BIN)/python analyses/how_many_steps.py
	$(BIN)/python analyses/how_well_can_silhouettes_tell.py
	for flight in $(FLIGHTS); do $(BIN)/flycontrol report --parameters drosophila_hydei --mapping muijres_freeflight \
	  --recording $(DATA)/muijres_freeflight/$$flight.txt --out reports/flights/$$flight || exit 1; done

coverage: $(VENV)/run.stamp
	$(BIN)/python analyses/interval_coverage.py

# A process on every core, up to four; the tests of a file stay together, since they share what was computed once.
CORES := -n auto --maxprocesses 4 --dist loadfile

test: $(VENV)/test.stamp
	$(BIN)/python -m pytest $(CORES)

test-all: $(VENV)/test.stamp
	$(BIN)/python -m pytest $(CORES) -m "slow or not slow"

fuzz: $(VENV)/test.stamp
	$(BIN)/python tests/io/fuzz_campaign.py

check: $(VENV)/check.stamp
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/basedpyright
	$(BIN)/lint-imports --no-cache
	$(BIN)/codespell

format: $(VENV)/check.stamp
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

bench: $(VENV)/bench.stamp
	$(BIN)/python -m pytest benchmarks --benchmark-enable --benchmark-only --benchmark-timer=time.process_time \
	  -m "slow or not slow"

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/run.stamp: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(PIP) -e .
	touch $@

$(VENV)/test.stamp: $(VENV)/run.stamp
	$(PIP) -e ".[test]"
	touch $@

$(VENV)/check.stamp: $(VENV)/test.stamp
	$(PIP) -e ".[test,check]"
	touch $@

$(VENV)/bench.stamp: $(VENV)/test.stamp
	$(PIP) -e ".[test,bench]"
	touch $@

clean:
	rm -rf $(VENV) .cache build *.egg-info .hypothesis .ruff_cache .pytest_cache
