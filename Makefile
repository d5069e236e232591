# phichain: `make` lists what can be done. Only Python 3.11 or newer, make and a C compiler are needed:
# everything else is installed into .venv on the first run.

PYTHON ?= python3
VENV   ?= .venv
OUT    ?= generated
N      ?= 4
SCENE  ?= planar$(N)
JOBS   ?= auto
PYTEST ?=
BENCH  ?=
QUICK  ?=

PY    := $(VENV)/bin/python
READY := $(VENV)/.ready
PEERS := $(VENV)/.ready-bench
READY_DOCS := $(VENV)/.ready-docs
PIP   := $(PY) -m pip install --quiet --disable-pip-version-check


.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help setup run test test-long generate lint types layers bench report stability study figures docs links browser rigs firmware clean distclean

help: ## list the targets
	@echo "phichain: from a Lagrangian to firmware, for pendulum chains"
	@echo
	@awk 'BEGIN { FS = ":.*## " } /^[a-z-]+:.*## / { printf "  make %-10s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)
	@echo
	@echo "  make generate N=8                      paper A's chain of eight links, in generated/planar8"
	@echo "  make generate SCENE=path/to/scene.toml your own chain"
	@echo "  make test PYTEST='-k cli -x'           more words for pytest"

setup: $(READY) ## prepare .venv (every other target does it when needed)

$(PY):
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "phichain needs Python 3.11 or newer, $(PYTHON) is not; say make PYTHON=/path/to/python3.11" >&2; exit 1; }
	@echo "preparing $(VENV) (once; a few minutes on a slow line)"
	@$(PYTHON) -m venv $(VENV) || \
	  { rm -rf $(VENV); echo "python3 -m venv failed; on Debian and Ubuntu install the package python3-venv" >&2; exit 1; }

$(READY): pyproject.toml | $(PY)
	@$(PIP) --editable '.[casadi,plot,study,dev]'
	@touch $@

$(PEERS): pyproject.toml $(READY)
	@echo "installing the peers to compare with (once)"
	@$(PIP) --editable '.[bench]'
	@touch $@

$(READY_DOCS): pyproject.toml $(READY)
	@$(PIP) --editable '.[docs]'
	@touch $@

run: $(READY) ## the whole path in one go: derive, emit, compile, simulate, trace, control, report
	@$(PY) -m phichain tour --out $(OUT)

# Small matrices: BLAS threads of two workers would only wait for each other.
test test-long: export OPENBLAS_NUM_THREADS = 1
test: $(READY) $(READY_DOCS) ## the tests, those of the documentation among them; all but the long ones
	@$(PY) -m pytest -n $(JOBS) --dist loadfile --no-loadscope-reorder -m 'not long' $(PYTEST)

test-long: $(READY) $(READY_DOCS) ## the long ones: sweeps over many scenes, mutants, trials
	@$(PY) -m pytest -n $(JOBS) --dist loadfile --no-loadscope-reorder -m long $(PYTEST)

generate: $(READY) ## write the C and CasADi folder of a chain: N=8, or SCENE=path/to/scene.toml
	@$(PY) -m phichain generate '$(SCENE)' --out '$(OUT)'

lint: $(READY) layers ## ruff and the layer contract
	@$(PY) -m ruff check .

types: $(READY) ## mypy
	@$(PY) -m mypy

layers: $(READY) ## the layer contract alone: who may import whom
	@$(PY) -c 'from importlinter.cli import lint_imports_command; lint_imports_command()' --no-logo

bench: $(PEERS) ## measure against the peers into benchmarks/results; goes on after an interruption (bench-flows: one table)
	@$(PY) -m benchmarks $(BENCH)

bench-%: $(PEERS)
	@$(PY) -m benchmarks $(subst -,_,$*)

report: $(PEERS) ## error against run time, beside the peers: tables and generated/report/work_precision.html (QUICK=1: minutes)
	@$(PY) -m benchmarks.work_precision --out '$(OUT)/report' $(if $(QUICK),--quick,--write)

stability: $(PEERS) ## stiff and extreme cases, case by method: table and generated/report/stability.html (QUICK=1: minutes)
	@$(PY) -m benchmarks.stability --out '$(OUT)/report' $(if $(QUICK),--quick,--write --resume)

study: $(READY) ## a small study with a picture, on every core: generated/study; goes on after an interruption
	@mkdir -p '$(OUT)/study'
	@$(PY) -m phichain study examples/study_two_links.toml --out '$(OUT)/study/two_links.zarr' --picture '$(OUT)/study/two_links.png' --of 'q[2]'

figures: $(READY) ## every figure of both papers and of the examples, in generated/figures
	@$(PY) -m phichain figure all --out $(OUT)/figures
	@for script in examples/*.py; do echo "$$script"; $(PY) "$$script" || exit 1; done

firmware: $(READY) ## generated C on emulated microcontrollers, point by point; says which packages it needs (WRITE=1: the table)
	@$(PY) -m benchmarks.firmware $(if $(WRITE),--write)

rigs: $(READY) ## the pictures of docs/rigs.md: three rigs held upright
	@$(PY) -m benchmarks.control.rigs

docs: $(READY_DOCS) ## the documentation site, strict, every code block, notebook and script run: generated/site/index.html
	@$(PY) -m docs.site --out '$(OUT)/site'

links: $(READY_DOCS) ## ask every address that pages name whether it is there; says where there is no network
	@$(PY) -m docs.site.links

browser: $(READY_DOCS) ## open the pages of docs, run and figures in Chromium, where there is one, and use their controls
	@$(PY) -m docs.site.browser $(wildcard $(OUT)/site $(OUT)/report $(OUT)/figures)

clean: ## remove what was generated and the caches, keep .venv
	@find generated -mindepth 1 -maxdepth 1 ! -name README.md ! -name reference -exec rm -rf {} +
	@rm -rf build dist .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	@find codegen tests benchmarks examples -name __pycache__ -type d -prune -exec rm -rf {} + 2>/dev/null || true

distclean: clean ## clean, and remove .venv as well
	@rm -rf $(VENV)
