# make hexagon and make test need Python 3.11 or later (headers, venv), a C compiler and a package index; they make .venv.

PYTHON ?= python3
ARGS ?=
COUNT ?= 1000

VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check install --quiet
COMPILED := $(wildcard runtime/*.pyx runtime/face/*.pxi runtime/*.h runtime/core/*/*.c runtime/core/*/*.h)

# golden listings: tests/golden/<name>/equations.txt of scenes/<name>.toml, and two without a scene file
SCENES := falling-hexagon four-bar open-chain
LOOP := --links 6
PINNED := --links 3 --pinned
FRESH := build/listings

CORE := runtime/core
STRICT := -std=c11 -Wall -Wextra -Wshadow -Werror -I$(CORE)

define NO_COMPILER
make: found no C compiler, expected cc, gcc or clang; install one and run make again:
  Debian, Ubuntu:  apt install gcc libc6-dev
  Fedora:          dnf install gcc
  macOS:           xcode-select --install
  elsewhere:       $(BIN)/python -m pip install ziglang
endef
export NO_COMPILER

.PHONY: help hexagon gallery quick test oldest another others hard figures fuzz fuzz-mechanisms lint warnings sanitize coverage types diff golden benchmarks formulations site release clean

help:
	@echo "make hexagon     simulate the falling hexagon and draw it"
	@echo "make gallery     the pictures and the page of docs/gallery anew, in a minute"
	@echo "make quick       a part of the tests in about a minute, for every save; ARGS goes to pytest"
	@echo "make test        all tests but the long ones; ARGS=\"-k impact\" goes to pytest"
	@echo "make oldest      the quick tests with the oldest versions of everything that pyproject.toml allows"
	@echo "make another     the quick tests with the newest other Python on this machine, and the bytes of scenes with both"
	@echo "make hard        the long tests: surveys, random sweeps, large mechanisms"
	@echo "make figures     all hard cases, with the largest counts, and the figures that they reach"
	@echo "make sanitize    the hard cases and 100 random tosses under the sanitizers, with gcc on Linux"
	@echo "make coverage    the lines of the core that tests run, per layer and file, with gcc; COVERAGE_TESTS chooses the tests"
	@echo "make fuzz        5,000 random loops on random grounds, others with SEED=1"
	@echo "make fuzz-mechanisms  random mechanisms against the dense reference, COUNT=1000"
	@echo "make lint        ruff, and clang-format for the core"
	@echo "make warnings    compile the core with every warning an error"
	@echo "make types       mypy --strict"
	@echo "make diff        compare the equations derived now with tests/golden"
	@echo "make golden      write tests/golden anew"
	@echo "make benchmarks  time derivation, compilation and evaluation"
	@echo "make formulations  compare with other formulations, into docs/formulations.md"
	@echo "make site        the documentation as a site with search, in site/index.html; needs no network once .venv is made"
	@echo "make release     the archives of a release in dist, each installed and tried in a fresh environment; publishes nothing"
	@echo "make clean       remove what was made: .venv, models in build, results, .cache; says what it leaves"
	@echo "PYTHON=python3.12 make ... chooses the Python that .venv is made from"

hexagon: $(VENV)/ccgen
	@$(BIN)/ccgen run scenes/falling-hexagon.toml --gif
	@echo
	@echo "The falling hexagon is in results/falling-hexagon:"
	@echo "  player.html    open it in a browser: plays, pauses, scrubs"
	@echo "  animation.gif  the same as a picture that moves"
	@echo "  plot.png       energy, heights and closure over time"
	@echo "  forces.png     what contacts push and joints carry over time; ccgen run --csv writes them as a table"

gallery: $(VENV)/ccgen
	@$(BIN)/python docs/scripts/gallery.py $(ARGS)

quick: $(VENV)/test
	@CCGEN_TEST_CACHE_DIR=$(CURDIR)/.cache/quick $(BIN)/python -m pytest -q -n auto --dist worksteal -m quick $(ARGS)

# A worker without work takes tests of another, so that no core waits for a long file. What lasted is told at the end.
TIER := -m pytest -n auto --dist worksteal --durations 10

test: $(VENV)/test
	@$(BIN)/python $(TIER) -m "not hard" $(ARGS)

hard: $(VENV)/test
	@$(BIN)/python $(TIER) -m hard $(ARGS)

# The quick tests with every dependency at its lower bound, in an environment of its own.
OLDEST := .cache/oldest

oldest: $(OLDEST)/installed
	@CCGEN_TEST_CACHE_DIR=$(CURDIR)/$(OLDEST)/cache $(OLDEST)/bin/python -m pytest -q -n auto --dist worksteal -m quick $(ARGS)

$(OLDEST)/installed: $(COMPILED) pyproject.toml setup.py
	$(PYTHON) -m venv --clear $(OLDEST)
	$(OLDEST)/bin/python backend/lower_bounds.py > $(OLDEST)/requirements.txt
	$(OLDEST)/bin/python -m pip --disable-pip-version-check install --quiet -r $(OLDEST)/requirements.txt
	$(OLDEST)/bin/python -m pip --disable-pip-version-check install --quiet --no-deps -e .
	@touch $@

# The quick tests with the newest other Python on this machine, and the bytes of some scenes with both: sums of floats differ
# between Pythons. NumPy is the same in both, as last digits of starts are those of its LAPACK. Where there is no other it says so, and that is all.
ANOTHER := .cache/another
ANOTHER_SCENES ?= four-bar slider-crank falling-hexagon jansen-leg quick-return planetary escapement trebuchet

another: $(VENV)/test
	@python=$$($(BIN)/python backend/another_python.py) || exit 1; \
	if test -z "$$python"; then echo "another Python: found none beside $$($(BIN)/python --version); nothing is compared"; exit 0; fi; \
	$(MAKE) --no-print-directory $(ANOTHER)/installed ANOTHER_PYTHON=$$python && \
	{ $(BIN)/python -m tests.support.scene_bytes $(ANOTHER_SCENES) > $(ANOTHER)/bytes-here & here=$$!; \
	$(ANOTHER)/bin/python -m tests.support.scene_bytes $(ANOTHER_SCENES) > $(ANOTHER)/bytes-there && wait $$here; } && \
	diff $(ANOTHER)/bytes-here $(ANOTHER)/bytes-there && \
	echo "$$($(BIN)/python --version) and $$($(ANOTHER)/bin/python --version): the same bytes of $(words $(ANOTHER_SCENES)) scenes" && \
	CCGEN_TEST_CACHE_DIR=$(CURDIR)/$(ANOTHER)/cache $(ANOTHER)/bin/python -m pytest -q -n auto --dist worksteal -m quick $(ARGS)

# The environments of both, without a test
others: $(OLDEST)/installed $(VENV)/test
	@python=$$($(BIN)/python backend/another_python.py) || exit 1; \
	test -z "$$python" || $(MAKE) --no-print-directory $(ANOTHER)/installed ANOTHER_PYTHON=$$python

$(ANOTHER)/installed: $(COMPILED) pyproject.toml setup.py
	$(ANOTHER_PYTHON) -m venv --clear $(ANOTHER)
	$(ANOTHER)/bin/python -m pip --disable-pip-version-check install --quiet -e '.[test]' \
		numpy==$$($(BIN)/python -c 'import numpy; print(numpy.__version__)')
	@touch $@

figures: $(VENV)/test
	@CCGEN_LARGE=1 CCGEN_ROUNDINGS=1 $(BIN)/python -m pytest -q tests/hard --deselect tests/hard/test_fuzz.py $(ARGS)

# The core and all models with the address and the undefined-behaviour sanitizer, in an environment of their own: what reads
# or writes beside its arrays, or overflows, ends the run there. Python itself keeps memory to its end: leaks are not asked for.
SANITIZED := .cache/sanitized
SANITIZERS := -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer
SANITIZED_TESTS ?= tests/hard

sanitize: $(SANITIZED)/installed
	@LD_PRELOAD=$$($(CC) -print-file-name=libasan.so) ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=1 \
		CC="$(CC) $(SANITIZERS)" CCGEN_CACHE_DIR=$(SANITIZED)/cache CCGEN_FUZZ=100 \
		$(SANITIZED)/bin/python -m pytest -q -p no:cacheprovider $(SANITIZED_TESTS) $(ARGS)

$(SANITIZED)/installed: $(COMPILED) pyproject.toml setup.py $(wildcard front/*.py generator/*.py generator/*/*.py runtime/*.py runtime/*/*.py)
	$(PYTHON) -m venv --clear $(SANITIZED)
	CCGEN_CORES=all CFLAGS="$(SANITIZERS) -g -O1" LDFLAGS="$(SANITIZERS)" $(SANITIZED)/bin/python -m pip --disable-pip-version-check install --quiet \
		'.[test]'
	@touch $@

# What part of the core the tests run, line by line, with gcc: an environment of its own as above, without optimisation. Tests
# that compile parts of the core by themselves do it with these flags too; what they find is under .cache/coverage/tests.
COVERED := .cache/coverage
COVERAGE := --coverage -O0
COVERAGE_TESTS ?= tests/core tests/methods tests/contact tests/runs tests/analysis tests/kernels/test_impact.py \
	tests/effects/test_drive.py tests/hard

coverage: $(COVERED)/installed
	@rm -rf $(COVERED)/tests && find $(COVERED) -name '*.gcda' -delete
	@CFLAGS="$(COVERAGE)" CCGEN_CACHE_DIR=$(CURDIR)/$(COVERED)/cache CCGEN_FUZZ=100 $(COVERED)/bin/python -m pytest -q \
		-p no:cacheprovider --basetemp=$(COVERED)/tests $(COVERAGE_TESTS) $(ARGS); tested=$$?; \
	$(COVERED)/bin/python tests/support/core_coverage.py $(COVERED) && exit $$tested

$(COVERED)/installed: $(COMPILED) pyproject.toml setup.py $(wildcard front/*.py generator/*.py generator/*/*.py runtime/*.py runtime/*/*.py)
	$(PYTHON) -m venv --clear $(COVERED)
	CCGEN_CORES=all CCGEN_LAST_FLAGS="$(COVERAGE)" LDFLAGS="--coverage" CCGEN_BUILD_BASE=$(COVERED)/build \
		$(COVERED)/bin/python -m pip --disable-pip-version-check install --quiet '.[test]'
	@touch $@

fuzz: $(VENV)/test
	@CCGEN_FUZZ=5000 $(if $(SEED),CCGEN_FUZZ_SEED=$(SEED)) $(BIN)/python -m pytest -q -s tests/hard/test_fuzz.py $(ARGS)

fuzz-mechanisms: $(VENV)/test
	@CCGEN_MECHANISMS=$(COUNT) $(BIN)/python -m pytest tests/kernels/test_random_mechanisms.py $(ARGS)

lint: $(VENV)/dev
	@$(BIN)/ruff check --output-format concise .
	@$(BIN)/ruff format --check --quiet . || { echo "not formatted; run: .venv/bin/ruff format ." >&2; exit 1; }
	@$(BIN)/clang-format --dry-run -Werror $(CORE)/*/*.[ch] || \
		{ echo "not formatted; run: .venv/bin/clang-format -i $(CORE)/*/*.[ch]" >&2; exit 1; }

# The core's C, without a warning over each of its types of numbers. Counts are small numbers that are never negative: what the
# compiler says of their signs is left out; of floats and long doubles, that literals are doubles.
warnings:
	@failed=0; for file in $(CORE)/*/*.c; do \
		$(CC) $(STRICT) -O1 -Wconversion -Wno-sign-conversion -c -o /dev/null $$file || failed=1; \
		for precision in 1 2; do $(CC) $(STRICT) -fsyntax-only -DCCGEN_PRECISION=$$precision $$file || failed=1; done; \
	done; exit $$failed

types: $(VENV)/dev
	@$(BIN)/mypy --strict front generator runtime

diff: $(VENV)/ccgen
	@$(BIN)/ccgen $(LOOP) --out $(FRESH)
	@$(BIN)/ccgen $(PINNED) --out $(FRESH)
	@different=0; compare() { echo "$$2:"; $(BIN)/ccgen diff "$$1" "$$2" || different=1; }; \
	for name in $(SCENES); do compare tests/golden/$$name/equations.txt scenes/$$name.toml; done; \
	for name in loop6 pinned3; do compare tests/golden/$$name $(FRESH)/$$name; done; \
	test $$different = 0 || { echo "equations have changed; if that is meant: make golden" >&2; exit 1; }

golden: $(VENV)/ccgen
	@$(BIN)/ccgen $(LOOP) --out $(FRESH)
	@$(BIN)/ccgen $(PINNED) --out $(FRESH)
	@set -e; for name in $(SCENES); do $(BIN)/ccgen --scene scenes/$$name.toml --out $(FRESH); done; \
	for name in $(SCENES) loop6 pinned3; do \
		mkdir -p tests/golden/$$name; \
		cp $(FRESH)/$$(echo $$name | tr - _)/equations.txt tests/golden/$$name/equations.txt; \
	done

benchmarks: $(VENV)/peers
	@$(BIN)/python benchmarks/forward_dynamics.py
	@$(BIN)/python benchmarks/walking.py
	@$(BIN)/python benchmarks/build_time.py
	@$(BIN)/python benchmarks/flight.py
	@$(BIN)/python benchmarks/batch.py
	@$(BIN)/python benchmarks/drop.py
	@$(BIN)/python benchmarks/threads.py
	@$(BIN)/python benchmarks/ensemble.py
	@$(BIN)/python benchmarks/with_contacts.py
	@$(BIN)/python benchmarks/scene_events.py
	@$(BIN)/python benchmarks/orbits.py
	@$(BIN)/python benchmarks/identification.py

formulations: $(VENV)/peers
	@$(BIN)/python benchmarks/formulations.py --write

# The documentation as a site, anew each time, so that nothing of a page that is gone stays. A broken link or anchor, a page that
# is in no menu, a formula that cannot be drawn is an error. Links that lead out of it are listed, not fetched.
SITE := site

site: $(VENV)/site
	@test ! -e $(SITE) || test -e $(SITE)/.buildinfo || { echo "make: $(SITE) was not made by make site; move it away" >&2; exit 1; }
	@rm -rf .cache/site && $(BIN)/python -m sphinx -q -W --keep-going -c docs/site -d .cache/site/doctrees . .cache/site/html
	@rm -rf $(SITE) && mv .cache/site/html $(SITE)
	@echo "written: $(SITE)/index.html; $$(wc -l < $(SITE)/external-links.txt) links lead out of it, listed in $(SITE)/external-links.txt"

# In an environment of its own: where the ziglang package is installed, everything else would find a compiler in it.
RELEASE := .cache/release-tools

release: $(RELEASE)/installed
	@$(RELEASE)/bin/python backend/release.py

$(RELEASE)/installed: pyproject.toml
	$(PYTHON) -m venv --clear $(RELEASE)
	$(RELEASE)/bin/python -m pip --disable-pip-version-check install --quiet --upgrade pip
	$(RELEASE)/bin/python -m pip --disable-pip-version-check install --quiet --group release
	@touch $@

clean:
	@$(BIN)/python -m ccgen.generator.cli.clean build results 2> /dev/null || \
		for made in build results; do test ! -e $$made || \
			echo "left: $$made, since there is no ccgen in $(VENV) that knows what is its own"; done
	@test ! -e $(VENV)/made || rm -rf $(VENV)
	@test ! -e $(VENV) || echo "left: $(VENV), which make did not make"
	@test ! -e $(SITE)/.buildinfo || rm -rf $(SITE)
	rm -rf .cache .editable .pytest_cache .hypothesis .mypy_cache .ruff_cache *.egg-info
	rm -f runtime/*.so
	find front generator templates runtime tests benchmarks -name __pycache__ -type d -prune -exec rm -rf {} +

# The environment. Each file stands for an installation that went well.

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "make: $(PYTHON) is not Python 3.11 or later; choose one: make PYTHON=python3.12 ..." >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' || \
		{ echo "make: $(PYTHON) has no venv; install it (Debian, Ubuntu: apt install python3-venv)" >&2; exit 1; }
	@test ! -e $(VENV) || test -e $(VENV)/pyvenv.cfg || \
		{ echo "make: $(VENV) is no virtual environment; move it away" >&2; exit 1; }
	$(PYTHON) -m venv --clear $(VENV)
	@touch $(VENV)/made

$(VENV)/ccgen: pyproject.toml setup.py $(COMPILED) | $(BIN)/python
	@$(BIN)/python -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "make: $(VENV) is not of Python 3.11 or later; remove it: rm -rf $(VENV)" >&2; exit 1; }
	@$(BIN)/python -m pip --version > /dev/null 2>&1 || $(BIN)/python -m ensurepip > /dev/null
	@{ test -n "$$CC" || command -v cc || command -v gcc || command -v clang || $(BIN)/python -c 'import ziglang'; } \
		> /dev/null 2>&1 || \
		{ echo "$$NO_COMPILER" >&2; exit 1; }
	@echo "installing ccgen into $(VENV): about a minute, up to five on a slow machine"
	@$(BIN)/python backend/environment.py
	@touch $@

$(VENV)/test $(VENV)/dev $(VENV)/peers $(VENV)/site: $(VENV)/ccgen
	$(PIP) 'ccgen[$(@F)]'
	@touch $@
