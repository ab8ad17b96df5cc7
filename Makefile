# A fresh clone needs Python >= 3.11 and make; everything else is installed into .venv, at the versions of requirements.lock.
PYTHON ?= python3
BIN := .venv/bin
STAMP := .venv/installed
# small matrices gain nothing from more threads, and lose a factor of 50 where processes share the machine
export OMP_NUM_THREADS ?= 1

.PHONY: install test studies slow report wheel oldest bench docs cf page browser faults

install: $(STAMP)

$(STAMP): requirements.lock pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "slipwave needs Python >= 3.11; set PYTHON=... for make")'
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --requirement requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	touch $(STAMP)

# the many processes that tests start keep their compiled bytecode, whatever the environment says
test: export PYTHONDONTWRITEBYTECODE =
test: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/pytest -m "not slow and not studies" -n 2 --dist worksteal

# those tests that take most of the time: quick runs of whole studies, with counterfeit figures that must turn them red
studies: export PYTHONDONTWRITEBYTECODE =
studies: $(STAMP)
	$(BIN)/pytest -m studies -n 2

# verification that is too slow for every change: orders, growth, noise
slow: export PYTHONDONTWRITEBYTECODE =
slow: $(STAMP)
	$(BIN)/pytest -m slow -n 2 --dist worksteal

# make report QUICK=1 takes the cheap version of every study
report: $(STAMP)
	$(BIN)/slipwave report $(if $(QUICK),--quick)

# the package as a wheel, installed into a fresh environment and used from another folder
wheel: $(STAMP)
	$(BIN)/python -m tests.wheel $(if $(QUICK),--quick-report)

# the tests with the oldest packages that pyproject.toml allows, in an environment of their own
oldest: export PYTHONDONTWRITEBYTECODE =
oldest: $(STAMP)
	$(BIN)/python -m tests.oldest

# run times and their ratios, against another program with YARDSTICK=PROGRAM.py; judges nothing
bench: export PYTHONDONTWRITEBYTECODE =
bench: $(STAMP) requirements-bench.lock
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --requirement requirements-bench.lock >/dev/null 2>&1 || \
	echo "numbalsoda cannot be built here (it needs gfortran and a C++ compiler): its LSODA and DOP853 are left out" >&2
	$(BIN)/python -m tests.bench $(if $(YARDSTICK),--yardstick $(YARDSTICK))

# pages and docstrings as a site, reports/docs/index.html
docs: $(STAMP) requirements-docs.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --requirement requirements-docs.lock
	$(BIN)/mkdocs build --quiet --strict

# files of results of every kind, by a checker of the CF conventions that shares nothing with slipwave
cf: $(STAMP) requirements-cf.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --requirement requirements-cf.lock
	$(BIN)/python -m tests.conventions

# the page of the last report in a browser: sizes, keys, print, dark mode, and an accessibility checker from outside
page: $(STAMP) requirements-page.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --requirement requirements-page.lock
	REPORT=$(or $(REPORT),reports) $(BIN)/pytest tests/page

# a browser for it where there is none: Debian's for the superuser, otherwise one of playwright's
browser: $(STAMP) requirements-page.lock
	@command -v chromium || command -v chromium-browser || command -v google-chrome || \
	if [ "$$(id -u)" = 0 ] && command -v apt-get; then apt-get update -q && apt-get install -q -y chromium; \
	else $(BIN)/python -m pip install --quiet --requirement requirements-page.lock && $(BIN)/playwright install chromium; fi

# make faults PART=4 plants one in four of the faults; the commit decides which
faults: $(STAMP)
	$(BIN)/python -m tests.faults $(if $(PART),--part $(PART))
