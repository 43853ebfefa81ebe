# `make demo` or `make test` on a fresh clone sets up first; see CONTRIBUTING.md.
PYTHON ?= python3
VENV := .venv/bin/python
# Twice as many as cores: what runs in real time, by one of them, waits for most of its time.
WORKERS = $(shell expr $$(nproc) \* 2)
export ROS_AUTOMATIC_DISCOVERY_RANGE ?= LOCALHOST
# These two belong to another environment, where one is active.
unexport _ROS_WHEELS_BOOTSTRAP_COMPLETE PYTHONHOME
# Without it each process compiles all that it imports anew: 2 s of a node's 3 to start.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: help setup core demo test check docs wheel lock clean
.DEFAULT_GOAL := help

help:  ## list the targets
	@grep -E '^[a-z]+:.*##' Makefile | sed -E 's/^([a-z]+):.*## /  make \1\t/' | expand -t 16

setup:  ## install everything into .venv (skips what is done); EXTRAS="view tune" only these extras
	@command -v $(PYTHON) >/dev/null || { echo "error: missing $(PYTHON); sudo apt-get install -y python3" >&2; exit 2; }
	@$(PYTHON) -m scripts.setup_env

core:  # what the demo needs, without the extras
	@$(MAKE) --no-print-directory setup EXTRAS="$(EXTRAS)"

demo: core  ## drive through a world, map it and navigate: writes out/demo
	@$(VENV) -m bringup demo --out out/demo

test: setup  ## run the tests in random order, on all cores
	$(VENV) -m pytest -q -n $(WORKERS) --maxprocesses=6 --dist=loadgroup --max-worker-restart=0 $(PYTEST_ARGS)

check: setup  ## style, types and the packages' layers
	$(VENV) -m ruff check .
	$(VENV) -m ruff format --check .
	$(VENV) -m mypy
	$(VENV) -m pytest -q tests/core/test_layers.py

docs:  ## the documentation as a site in out/docs, its links checked (needs the network once)
	@$(PYTHON) -m scripts.docs_site

wheel: setup  ## both wheels into dist/
	@rm -rf build && mkdir -p build/wheel dist && cp .setup/wheels/*/*.whl dist/
	@tar -c --exclude='./.*' --exclude=./build --exclude=./dist --exclude=./out --exclude=./tests \
		--exclude=__pycache__ --exclude='*.egg-info' . | tar -x -C build/wheel
	cd build/wheel && ../../$(VENV) -m scripts.kernels ship
	$(VENV) -m pip -q wheel --no-deps --no-build-isolation -w dist build/wheel

lock:  ## make the lock files again from their .in files (needs the network)
	$(PYTHON) -m scripts.lock

clean:  ## remove all that make made
	rm -rf .venv .setup build dist out arjuna_interfaces/build ./*.egg-info arjuna_interfaces/*.egg-info
