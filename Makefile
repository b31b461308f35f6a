# Targets for people. They set up what is missing first; a run needs less than the tests.

PYTHON ?= python3
APT ?= yes
HDF5_DIR ?=
INPUT ?= inputs/quickstart.yaml
RANKS ?= 2
ARGS ?=
SCALE ?= 0.01
SECTIONS ?=

STAMP = .venv/set-up
DEVELOP = .venv/set-up-dev
SETUP = PYTHON="$(PYTHON)" APT="$(APT)" HDF5_DIR="$(HDF5_DIR)" tools/setup.sh
VENV_PYTHON = .venv/bin/python

# For mpirun on one's own machine: as root, with more ranks than cores, one thread per rank.
# The last line is for Open MPI 5. On a cluster none of these belongs in a job.
export OMPI_ALLOW_RUN_AS_ROOT = 1
export OMPI_ALLOW_RUN_AS_ROOT_CONFIRM = 1
export OMPI_MCA_rmaps_base_oversubscribe = 1
export OMP_NUM_THREADS = 1
export OPENBLAS_NUM_THREADS = 1
export NUMBA_NUM_THREADS = 1
export PRTE_MCA_rmaps_default_mapping_policy = :oversubscribe

# Containers set it; then each of the many programs that the tests start compiles every module anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: help setup run test test-long test-faults staying test-slurm validate stress bench scaling blisk rotor67 reproduce lint reference docs links clean
.DEFAULT_GOAL := help

help:  ## this list
	@sed -nE 's/^([a-z0-9-]+):.*## +(.*)/make \1\t\2/p' Makefile | expand -t 18

setup:  ## set up .venv, with what tests and tables need, too (PYTHON=... APT=no HDF5_DIR=...)
	@EXTRAS=mpi,dev $(SETUP)

$(STAMP): pyproject.toml tools/setup.sh
	@$(SETUP)

$(DEVELOP): pyproject.toml tools/setup.sh
	@EXTRAS=mpi,dev $(SETUP)

run: $(STAMP)  ## run a study or go on with it (INPUT=... RANKS=2 ARGS=--overwrite)
	mpirun -n $(RANKS) $(VENV_PYTHON) main.py "$(INPUT)" \
	    $(if $(findstring --overwrite,$(ARGS)),,--resume) $(ARGS)

test: $(DEVELOP)  ## run all tests but the long ones, as many at once as there are cores (ARGS="-k config", ARGS="-n 0")
	@$(VENV_PYTHON) -m pytest -n auto --dist worksteal -m "not long" $(ARGS)

test-long: $(DEVELOP)  ## run the tests that take long (3 min)
	@$(VENV_PYTHON) -m pytest -n auto --dist worksteal -m long $(ARGS)

test-slurm: $(DEVELOP)  ## run the job scripts on a Slurm of this machine (root; 4 min)
	@command -v slurmctld >/dev/null || { apt-get update -q; apt-get install -q -y --no-install-recommends slurm-wlm munge; }
	@$(VENV_PYTHON) -m pytest tests/slurm $(ARGS)

validate: $(STAMP)  ## hold the kernel against exact solutions, write docs/validation.md (3 min; ARGS=run_up)
	@$(VENV_PYTHON) -m evidence.validation $(ARGS)

stress: $(STAMP)  ## thousands of runs in the corners of the input, write docs/stress.md (20 min; ARGS=--fast)
	@$(VENV_PYTHON) -m evidence.stress $(ARGS)

staying: $(STAMP)  ## follow motions on that are called steady, write docs/staying.md (30 min; ARGS=tuned)
	@$(VENV_PYTHON) -m evidence.staying $(ARGS)

test-faults: $(STAMP)  ## break disks, files and processes on purpose, write docs/faults.md (20 to 40 min)
	@$(VENV_PYTHON) -m evidence.faults $(ARGS)

lint: $(DEVELOP)  ## check style, docstrings and types
	@$(VENV_PYTHON) -m ruff check .
	@$(VENV_PYTHON) -m ruff format --check .
	@$(VENV_PYTHON) -m mypy

bench: $(STAMP)  ## measure speed, write evidence/benchmarks/report.md (7 min; ARGS=kernel)
	@$(VENV_PYTHON) -m evidence.benchmarks $(ARGS)

scaling: $(STAMP)  ## measure how a study scales on this machine, write docs/scaling.md (1 min)
	@$(VENV_PYTHON) -m evidence.scaling $(ARGS)

blisk: $(STAMP)  ## make the blisk of the tutorial with CalculiX, and check it (1 min)
	@command -v ccx >/dev/null || apt-get install -q -y --no-install-recommends calculix-ccx
	@$(VENV_PYTHON) -m evidence.blisk

rotor67: $(STAMP)  ## compute the benchmark of NASA rotor 67 (8 min at SCALE=0.1 of its fans; SECTIONS=FILE begins there)
	@[ -z "$(SECTIONS)" ] || command -v ccx >/dev/null || apt-get install -q -y --no-install-recommends calculix-ccx
	@$(VENV_PYTHON) -m evidence.rotor67 --scale $(SCALE) --ranks $(RANKS) $(if $(SECTIONS),--sections "$(SECTIONS)") $(ARGS)

reproduce: $(STAMP)  ## run the whole paper, or go on, and write docs/reproduction.md (SCALE=0.01 RANKS=2)
	@$(VENV_PYTHON) -m evidence.reproduce --scale $(SCALE) --ranks $(RANKS) $(ARGS)

reference: $(STAMP)  ## write the tables of docs/reference anew, and the numbers of the quick start
	@$(VENV_PYTHON) -m docs.tables

docs: reference .venv/set-up-docs  ## build the site in build/docs; fails at a broken link inside
	@$(VENV_PYTHON) -m sphinx -q --fail-on-warning --keep-going docs build/docs
	@echo "open build/docs/index.html"

links: .venv/set-up-docs  ## try every link of the documents to other sites (needs a network)
	@$(VENV_PYTHON) -m sphinx -q -b linkcheck -D nb_execution_mode=off \
	    -D suppress_warnings=myst-nb.lexer docs build/links

.venv/set-up-docs: $(STAMP)
	@$(VENV_PYTHON) -m pip install -q --disable-pip-version-check --no-build-isolation --editable '.[docs,tables]'
	@touch $@

clean:  ## remove what can be made again (not .venv, not results)
	rm -rf build *.egg-info .pytest_cache .ruff_cache .mypy_cache .hypothesis
	rm -rf "$${XDG_CACHE_HOME:-$$HOME/.cache}/hpcrub/jit"
	find . -name __pycache__ -not -path './.venv/*' -prune -exec rm -rf {} +
