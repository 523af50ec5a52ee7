# make demo   run the first example against the virtual robot and draw its timing chart: rcx demo
# make test   run the quick tests: every block, command and rule, a sample of the large matrices
# make test-all  run all tests
# make fuzz   attack the EtherNet/IP adapter: FOR=60s or COUNT=20000, SEED=1 to repeat a run
# make bench  measure speed beside targets, out/bench.json: ONLY=handshake,cyclic RPI=10ms FOR=60s
#             ONLY=language: what is accepted of the libraries (folders, projects) in RCX_LIBRARIES
# make lint   check format, types, the portability of the ST, and that generated files are current
# make docs   write the generated pages and the README's output blocks anew; docs/how-to/view.png needs chromium
# make verification   run every check below whose sources have changed; write docs/explanation/verification.md
#   contract, coverage, mutants, explore, campaign: one check; MORE="..." goes to it
# make site   write the pages as a web site with the playground, out/site; it needs npm
#   site-test: and run its tests in chromium
# make prove  prove the rules for every program, out/prove.json; LIB=folder: another copy of plc/lib,
#             without the seeded bugs; MORE="interval handshake": some properties, out/prove/part.json
# make newest run all tests with the newest versions of what is needed, in out/newest
# make lock   write requirements/ anew, after a change of pyproject.toml; MORE=--upgrade: newest
# Each does its own set-up in .venv, from the versions that requirements/ locks by their hashes.
# It takes PYTHON=... where python3 is older than 3.10.

PYTHON ?= python3
BIN := .venv/bin
READY := .venv/.ready

# Modules are compiled once, not by each process that imports them.
export PYTHONDONTWRITEBYTECODE :=

# One process more than there are processors, since some tests wait for other programs.
# make test has one process for each processor. The long tests wait more: one process more.
PROCESSORS = $(shell $(BIN)/python -c "import os; print(os.cpu_count() or 1)")
PROCESSES = $(shell $(BIN)/python -c "import os; print((os.cpu_count() or 1) + 1)")
# The packages of the wheel.
PACKAGES := harness/rcx_harness harness/structured_text

CHECKS := prove contract coverage mutants explore campaign

PIP := -m pip install --quiet --disable-pip-version-check
COMPILE := out/lock/bin/uv pip compile --quiet --universal --python-version 3.10 --generate-hashes \
  --custom-compile-command "make lock" $(MORE)

.PHONY: demo test test-all test-toolkit fuzz bench lint docs site site-test newest lock clean verification $(CHECKS)

demo: $(READY)
	@$(BIN)/rcx demo

test: $(READY)
	@echo "make test takes two to three minutes on two quiet cores"
	@$(BIN)/python -m pytest -n $(PROCESSORS) --dist worksteal -q -m "not exhaustive" $(MORE)

test-toolkit: $(READY)
	@$(BIN)/python -m pytest -p no:rcx --toolkit-alone -n $(PROCESSES) -q tests/structured_text $(MORE)

test-all: $(READY)
	@echo "make test-all takes about half an hour on two cores"
	@$(BIN)/python -m pytest -n $(PROCESSES) --dist worksteal -q $(MORE)

fuzz: $(READY)
	@$(BIN)/python tests/support/enip_fuzz.py --for $(or $(FOR),60s) \
	  $(if $(COUNT),--count $(COUNT)) $(if $(SEED),--seed $(SEED))

bench: $(READY)
	@$(BIN)/python -m rcx_tools.bench --only "$(ONLY)" $(if $(RPI),--rpi "$(RPI)") \
	  $(if $(FOR),--for "$(FOR)") $(MORE)

lint: $(READY)
	$(BIN)/ruff check harness tests
	$(BIN)/ruff format --check harness tests
	$(BIN)/mypy
	$(BIN)/mypy --platform win32 --cache-dir .mypy_cache/win32 $(PACKAGES)
	$(BIN)/mypy --platform darwin --cache-dir .mypy_cache/darwin $(PACKAGES)
	$(BIN)/rcx check --lint plc
	$(BIN)/python -m rcx_tools.docs.pages --check
	@$(BIN)/python -m rcx_tools.evidence.report --remind

docs: $(READY)
	$(BIN)/python -m rcx_tools.docs.pages
	$(BIN)/python -m rcx_tools.docs.view_picture

site: .venv/.site
	@$(BIN)/python -m rcx_tools.site

site-test: site
	@$(BIN)/python -m pytest -m external tests/tools/site

.venv/.site: $(READY) requirements/site.txt
	@$(BIN)/python -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "make site needs Python 3.11 or newer: make clean site PYTHON=/path/to/python3.12"; exit 2; }
	@$(BIN)/python $(PIP) --require-hashes -r requirements/site.txt
	@touch $@

verification: $(READY)
	@$(BIN)/python -m rcx_tools.evidence.report $(MORE)

prove: WITH = $(if $(LIB),--lib "$(LIB)")
$(CHECKS): $(READY)
	@$(BIN)/python -m rcx_tools.evidence.report --only $@ $(WITH) $(MORE)

newest: $(READY)
	@$(PYTHON) -m venv --clear out/newest
	@out/newest/bin/python $(PIP) --upgrade pip
	@out/newest/bin/python $(PIP) -e '.[dev]'
	@out/newest/bin/python -m pip list
	@out/newest/bin/python -m pytest -n auto --dist worksteal $(MORE)

lock:
	@$(PYTHON) -m venv --clear out/lock
	@out/lock/bin/python $(PIP) uv
	@$(COMPILE) --extra dev pyproject.toml requirements/build.in -o requirements/dev.txt
	@$(COMPILE) requirements/build.in -c requirements/dev.txt -o requirements/build.txt
	@$(subst 3.10,3.11,$(COMPILE)) requirements/site.in -c requirements/dev.txt -o requirements/site.txt

clean:
	rm -rf .venv out

$(READY): pyproject.toml requirements/build.txt requirements/dev.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' || \
	  { echo "Python 3.10 or newer is needed: make $(MAKECMDGOALS) PYTHON=/path/to/python3.12"; exit 2; }
	@echo "Setting up .venv (once; a minute or two) ..."
	@$(PYTHON) -m venv .venv || \
	  { echo "Python's venv module is needed (Debian and Ubuntu: python3-venv)"; exit 2; }
	@$(BIN)/python $(PIP) --require-hashes -r requirements/build.txt
	@$(BIN)/python $(PIP) --require-hashes --no-build-isolation -r requirements/dev.txt
	@$(BIN)/python $(PIP) --no-build-isolation --no-deps -e .
	@# All modules are compiled here, not by each process that imports them.
	@$(BIN)/python -m pytest --collect-only -qq > /dev/null 2>&1 || true
	@touch $@
