# Two commands do everything: `make study` (the example and its year, or CONFIG=...), `make test`.
PYTHON ?= $(shell command -v python3.11 || command -v python3)
CONFIG ?= config/buoy.yaml config/year.yaml
MARKS ?= not slow
BIN := .venv/bin
ONE_THREAD := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
READY := .venv/.installed

.PHONY: verification study benchmark barge claims published hard-cases torture cluster-test test test-all lint unit format docs links container lock docs-lock clean help

study: $(READY) ## run the example study and its year, or others: make study [CONFIG=config/seed.yaml]
	@for one in $(CONFIG); do $(BIN)/vsb run $$one || exit; done

SPEED := $(patsubst %,results/benchmarks/%.csv,machine coefficients motion paper growth shares)

benchmark: $(SPEED) ## docs/speed.md anew: error against seconds, growth, shares; what is in results/benchmarks is kept. One table: make results/benchmarks/growth.csv
	@mkdir -p docs/published/speed && cp $(SPEED) docs/published/speed
	@$(BIN)/python -m examples.published --stored

results/benchmarks/motion.csv: $(READY)
	@$(ONE_THREAD) $(BIN)/python -m benchmarks time-domain config/few_modes.yaml $@

results/benchmarks/paper.csv: $(READY)
	@$(ONE_THREAD) $(BIN)/python -m benchmarks time-domain config/paper.yaml $@

results/benchmarks/%.csv: $(READY)
	@$(ONE_THREAD) $(BIN)/python -m benchmarks $* $@

barge: $(READY) ## any body by the general route: a flexible barge
	@$(BIN)/python -m examples.barge config/barge_convergence.yaml results/barge

claims: $(READY) ## published claims about flexible devices, recomputed: tables, figures and studies of docs/claims.md
	@$(BIN)/python -m examples.claims results/claims

published: $(READY) ## every number, table and picture of README and docs that a command writes, anew; or some: make published [SOURCE=study]
	@$(ONE_THREAD) $(BIN)/python -m examples.published $(SOURCE)

hard-cases: $(READY) ## table of the cases that break other codes
	@$(BIN)/python -m benchmarks hard-cases config/hard_cases.yaml results/hard_cases.csv

torture: $(READY) ## a thousand random studies and 700 damaged results: refused in one line or completed
	@$(BIN)/python -m benchmarks torture 1000 results/torture.csv
	@$(BIN)/python -m benchmarks damage 700 results/damage.csv

cluster-test: .venv-cluster/.installed ## a campaign on a real Slurm of one node, killed and resumed (Debian: slurm-wlm, munge)
	@PATH="$(CURDIR)/$(BIN):$$PATH" .venv-cluster/bin/python -m benchmarks cluster results/cluster

test: $(READY) ## style, types, workflow lint, and the quick tests
	@$(MAKE) --no-print-directory --jobs=2 lint unit

test-all: $(READY) ## style, types, workflow lint, and all tests, the slow ones too
	@$(MAKE) --no-print-directory --jobs=2 lint unit MARKS="slow or not slow"

verification: $(READY) ## every capability against computations that share nothing with the package, see docs/verification.md: some ten minutes
	@PATH="$(CURDIR)/$(BIN):$$PATH" OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/pytest -q -n 2 --dist loadfile -o addopts="--import-mode=importlib" tests/verification

lint: $(READY)
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/mypy --strict vsb benchmarks examples
	@$(BIN)/snakefmt --check Snakefile workflow
	@PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/snakemake --lint

# Compiled tests are kept whatever the environment says: both workers compile all of them.
unit: $(READY)
	@PYTHONDONTWRITEBYTECODE= PATH="$(CURDIR)/$(BIN):$$PATH" OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/pytest -q -n 2 --dist loadfile --no-loadscope-reorder -m "$(MARKS)"

format: $(READY) ## put the code in its standard form
	@$(BIN)/ruff check --fix .
	@$(BIN)/ruff format .
	@$(BIN)/snakefmt Snakefile workflow

docs: .venv-docs/.installed ## the documentation, to docs/_build/html/index.html; every warning is an error
	@.venv-docs/bin/python -m sphinx -W --keep-going -q -b html docs docs/_build/html
	@echo docs/_build/html/index.html

links: .venv-docs/.installed ## every link of the documentation to the outside, asked once; needs a network
	@.venv-docs/bin/python -m sphinx -q -b linkcheck docs docs/_build/links

container: ## the image `vsb` from Dockerfile, by what is at hand of docker, podman and buildah, and what it says of itself
	@for tool in docker podman buildah none; do $$tool info >/dev/null 2>&1 && break; done; \
	case $$tool in \
	none) echo "needs docker with its daemon, podman or buildah: none of them answers here"; exit 1;; \
	buildah) buildah build -t vsb . && c=$$(buildah from vsb) && buildah run $$c -- vsb --version && buildah rm $$c >/dev/null;; \
	*) $$tool build -t vsb . && $$tool run --rm vsb --version;; \
	esac

# Sphinx beside the package's own environment, which it sees through a path file: a study needs none of it.
.venv-docs/.installed: docs/requirements.lock $(READY)
	@$(PYTHON) -m venv --clear .venv-docs
	@.venv-docs/bin/pip install --quiet --disable-pip-version-check --no-deps -r docs/requirements.lock
	@$(BIN)/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))' \
		> $$(.venv-docs/bin/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')/vsb.pth
	@touch $@

# Likewise Snakemake's plug-in for Slurm: every start of snakemake would import it.
.venv-cluster/.installed: benchmarks/cluster-requirements.lock $(READY)
	@$(PYTHON) -m venv --clear .venv-cluster
	@.venv-cluster/bin/pip install --quiet --disable-pip-version-check --no-deps -r benchmarks/cluster-requirements.lock
	@$(BIN)/python -c 'import sysconfig; print("$(CURDIR)", sysconfig.get_path("purelib"), sep="\n")' \
		> $$(.venv-cluster/bin/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')/vsb.pth
	@touch $@

$(READY): requirements.lock pyproject.toml
	@$(PYTHON) -c 'import sys; v = sys.version_info[:2]; sys.exit(None if (3, 11) <= v < (3, 14) else "vsb needs Python 3.11 to 3.13, $(PYTHON) is %d.%d; set PYTHON=..." % v)'
	@echo "creating .venv (once, about a minute)"
	@$(PYTHON) -m venv --clear .venv
	@$(BIN)/pip install --quiet --disable-pip-version-check -r requirements.lock
	@$(BIN)/pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	@touch $(READY)

lock: ## resolve the dependencies anew into requirements.lock
	@$(PYTHON) -m venv .venv-lock && .venv-lock/bin/pip install --quiet pip-tools
	@.venv-lock/bin/pip-compile --quiet --extra dev --all-build-deps --allow-unsafe --strip-extras \
		--no-emit-index-url --no-emit-trusted-host --no-emit-find-links --output-file requirements.lock pyproject.toml
	@rm -rf .venv-lock

docs-lock: ## resolve the documentation's own tools anew into docs/requirements.lock
	@$(PYTHON) -m venv .venv-lock && .venv-lock/bin/pip install --quiet pip-tools
	@.venv-lock/bin/pip-compile --quiet --strip-extras --no-emit-index-url --no-emit-trusted-host --no-emit-find-links \
		--output-file docs/requirements.lock docs/requirements.txt
	@rm -rf .venv-lock

clean: ## remove the environment and all results
	@rm -rf .venv .venv-docs .venv-cluster docs/_build docs/reference .snakemake
	@find results -mindepth 1 ! -name README.md -delete

help: ## this list
	@grep -hE '^[a-z]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 12
