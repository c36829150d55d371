# make setup   .venv from the lock file         make demo      the whole path, from a name to three verdicts
# make test    the tests that a change needs    make test-all  the long tests, which `make test` leaves out
# make lint    linter, formatter, type checker  make test ARGS="-k badge -x"   arguments for pytest
# make docs    the guides, into site/           make gallery   their pictures
# make wheel   wheel and source archive in dist/   make audit   are known holes in what is locked?
# make platform-wheels  wheels for Linux, macOS and Windows, in build/platforms
# make wheels  what a container image is made of, with `make debs`: see deploy/Containerfile
# make schemas  the shipped JSON Schemas, from the models   make claims  tests/claims.md, from the tests
# make lock    the lock files and the list of parts   make release   tests of an installed wheel, audit, wheel
PYTHON ?= python3
ENGINE ?= podman
BIN := .venv/bin
# Not in .venv: what checks its output makes every `import jsonschema` take a second.
PARTS_VERSION := 7.5.0
THREE_VERSION := 0.187.0
ESBUILD_VERSION := 0.28.2
UV_VERSION := 0.13.8
# More workers than most machines have spare cores: many tests wait for a process, a browser or a clock.
# What Python compiled is kept: the workers, and the programs that tests start, read it instead of compiling anew.
PYTEST := PYTHONDONTWRITEBYTECODE= $(BIN)/python -m pytest -n 3 --dist worksteal --durations 10
PROJECTS := pyproject.toml studio/pyproject.toml lab/pyproject.toml
# What a server of a studio needs; the rest is for those who develop moireid.
SERVER := cad postgres face c2pa cluster
# For Python 3.11 to 3.13 on Linux, macOS and Windows; with hashes, and no place to download from.
RESOLVE := $(BIN)/uv pip compile --generate-hashes --no-emit-index-url --no-emit-find-links --no-emit-package moireid --universal --python-version 3.11

.PHONY: setup demo test test-all lint docs gallery schemas claims lock three parts audit wheel platform-wheels wheels debs release clean

setup: .venv/.ready

# The stamp is newer than what it was made from, so a second `make` costs nothing.
.venv/.ready: locks/requirements.lock $(PROJECTS) hatch_build.py $(wildcard src/moireid/verifier/kernel/*.[ch])
	@$(PYTHON) -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 14))' || { echo "error: Python 3.11, 3.12 or 3.13 is needed; try make PYTHON=python3.12" >&2; exit 2; }
	test -x $(BIN)/python || $(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check uv==$(UV_VERSION)
	$(BIN)/uv pip install --quiet --python $(BIN)/python --require-hashes -r locks/requirements.lock
	@# The compiler of the kernel is that of the lock.
	$(BIN)/uv pip install --quiet --python $(BIN)/python --no-deps --no-build-isolation -e . -e studio -e lab
	@# What a verify loads is compiled here once: uv leaves that to the first run, and some machines forbid Python to keep it.
	PYTHONDONTWRITEBYTECODE= $(BIN)/moireid verify tests/data/films/genuine_1.0m.mp4 --badge tests/data/films/badge.json --json >/dev/null
	@# And what a badge without a mount loads.
	@folder=$$(mktemp -d) && PYTHONDONTWRITEBYTECODE= MOIREID_KEYS=$$folder/keys $(BIN)/print-your-badge Ada --out $$folder/badge --mount none --registry sqlite:///$$folder/people.sqlite3 --json >/dev/null && rm -r $$folder
	touch $@

demo: setup
	@PATH="$(CURDIR)/$(BIN):$$PATH" bash examples/demo.sh

test: .venv/.compiled
	$(PYTEST) -m "not slow" $(ARGS)

# Where nothing fits ARGS, pytest ends with 5.
test-all: .venv/.compiled
	$(PYTEST) -m "slow and not alone" $(ARGS) || [ $$? -eq 5 ]
	PYTHONDONTWRITEBYTECODE= $(BIN)/python -m pytest --durations 10 -m "slow and alone" $(ARGS) || [ $$? -eq 5 ]

# Numba compiles the renderer for half a minute and keeps what it made; here, or else two workers do it side by side.
.venv/.compiled: .venv/.ready $(shell find src/moireid/simulate -name '*.py')
	PYTHONPATH=tests $(BIN)/python -m kit.compiling
	touch $@

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo --no-cache

# The theme would tell of its maintainers' plans in each build.
docs: setup
	$(BIN)/python -m moireid_lab.bench.scoreboard_tables
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict

gallery: setup
	$(BIN)/python docs/make_gallery.py

schemas: setup
	PYTHONPATH=tests $(BIN)/python -m kit.schemas

claims: setup
	PYTHONPATH=tests $(BIN)/python -m kit.claims

# Each list of parts is written from an environment of its own, so that it names licences and who needs whom.
lock:
	$(RESOLVE) $(PROJECTS) --all-extras --output-file locks/requirements.lock
	$(RESOLVE) pyproject.toml studio/pyproject.toml $(SERVER:%=--extra %) --constraint locks/requirements.lock --output-file locks/requirements-server.lock
	$(MAKE) --no-print-directory parts OF=pyproject.toml EXTRAS="cad postgres face c2pa simulate" TO=locks/moireid.cdx.json
	mkdir -p build && sed '/"moireid==/d; /tool.uv.sources/,/^$$/d' studio/pyproject.toml > build/pyproject.toml
	$(MAKE) --no-print-directory parts OF=build/pyproject.toml EXTRAS="cluster" TO=studio/moireid-studio.cdx.json

# parts OF=pyproject.toml EXTRAS="..." TO=FILE: a list of the parts of one distribution; the studio's leaves out moireid's.
parts:
	$(BIN)/uv venv --quiet --clear --python $(BIN)/python build/parts
	$(RESOLVE) $(OF) $(EXTRAS:%=--extra %) --constraint locks/requirements.lock --quiet --output-file build/parts/requirements.lock
	$(BIN)/uv pip install --quiet --python build/parts/bin/python --require-hashes -r build/parts/requirements.lock
	$(BIN)/uv tool run --quiet --from cyclonedx-bom==$(PARTS_VERSION) cyclonedx-py environment --pyproject $(OF) --output-reproducible --output-file $(TO) build/parts/bin/python
	build/parts/bin/python .ci/parts.py $(TO) locks/requirements.lock

# The library by which the studio draws in 3D, as one file; it needs node, and `make lock` afterwards notes it.
three:
	mkdir -p build/three && cp .ci/three.js build/three/
	cd build/three && npm install --no-audit --no-fund three@$(THREE_VERSION) esbuild@$(ESBUILD_VERSION)
	cd build/three && npx esbuild three.js --bundle --minify --format=esm --legal-comments=eof --outfile=bundled.js
	cp build/three/bundled.js studio/src/moireid_studio/static/three.js
	cp build/three/node_modules/three/LICENSE studio/src/moireid_studio/static/three.LICENSE

# What a container image is built of, without a network (deploy/Containerfile).  The second asks a container engine.
wheels: setup
	mkdir -p build/wheels
	$(BIN)/python -m pip download --quiet --disable-pip-version-check --require-hashes --only-binary :all: --dest build/wheels --requirement locks/requirements-server.lock
	rm -f build/wheels/moireid*.whl
	bash .ci/build build/made > /dev/null
	cp build/made/*.whl build/wheels/

debs:
	mkdir -p build/debs
	$(ENGINE) run --rm --volume "$(CURDIR)/build/debs:/debs" docker.io/library/python:3.11-slim-trixie sh -c 'apt-get update && apt-get install --yes --download-only libgl1 libx11-6 libxrender1 && cp /var/cache/apt/archives/*.deb /debs'

audit: setup
	$(BIN)/python .ci/audit.py locks/requirements.lock --parts locks/moireid.cdx.json --parts studio/moireid-studio.cdx.json

wheel: setup
	bash .ci/build dist

# Those of moireid for other machines, which this one compiles too.
platform-wheels: setup
	$(BIN)/python hatch_build.py build/platforms

release: setup
	MOIREID_NEWEST=1 $(PYTEST) tests/end_to_end/test_wheel.py tests/end_to_end/test_installed.py $(ARGS)
	$(BIN)/python .ci/audit.py locks/requirements.lock --parts locks/moireid.cdx.json --parts studio/moireid-studio.cdx.json || test $$? -eq 3
	bash .ci/build dist

clean:
	rm -rf demo build dist site .pytest_cache .mypy_cache .ruff_cache
