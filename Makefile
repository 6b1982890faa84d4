# make demo: set everything up and run the main job.   make test: set up and pass the tests.
# Continuous integration runs lint, test and long: .ci/run.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
# A process for each core takes tests that stand together, which share what is built for them; one
# more would import everything once more. Threads for the small matrices of a test would only get
# in each other's way: they double the time of the processors.
# What Python compiles it keeps, even where the shell says otherwise: every process of a test and
# every further run would compile it anew.
PYTEST = PYTHONDONTWRITEBYTECODE= OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest
WORKERS = -n logical --dist worksteal
FMUS := dist/compensator.fmu dist/plant.fmu

TRAINING := training_down training_random training_stops training_warm_hall

.PHONY: demo control test long docs lint build compensator bench clean
.DELETE_ON_ERROR:

$(STAMP): pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or newer is needed; say make PYTHON=python3.12, for example")'
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev,benchmarks]'
	touch $@

build: $(STAMP)
	$(BIN)/python build_fmu.py

demo: $(STAMP)
	$(BIN)/python build_fmu.py
	@# The same in C run faster; without a compiler those in Python do it.
	$(BIN)/python build_fmu.py --native || true
	$(BIN)/spindle-drift run step_speed --out results/step_speed

# A working day at LinuxCNC in eight minutes; it needs linuxcnc-uspace and linuxcnc-uspace-dev.
control: $(STAMP)
	$(BIN)/python build_fmu.py
	$(BIN)/python -m benchmarks.linuxcnc

# Fits the compensator that ships with the package anew; the result is the same file, byte for byte.
compensator: $(STAMP)
	mkdir -p build/training
	for run in $(TRAINING); do $(BIN)/spindle-drift simulate $$run --force -o build/training/$$run.csv || exit; done
	$(BIN)/spindle-drift fit $(TRAINING:%=build/training/%.csv) --machine jig_borer \
	    --name jig_borer -o fmu_compensator/library/jig_borer.json

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

test: $(STAMP)
	$(PYTEST) $(WORKERS) -m "not vcan and not long"

# What takes longer than a change should wait: questions to the gap finder, other masters and
# platforms, many examples, the installed wheel, whole measured data sets, the benchmarks' own parts,
# and a kernel with CAN.
long: $(STAMP)
	$(PYTEST) $(WORKERS) -m "(long or hypothesis) and not vcan" --hypothesis-profile many \
	    --deselect tests/gateway/test_component.py
	@# A control in real time, whose answers come too late beside other tests.
	$(PYTEST) -m long tests/gateway/test_component.py
	$(BIN)/python tests/gateway/on_vcan.py

# The pages as a site in build/site. Its notebooks are run, from their own folder.
docs: $(STAMP)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[docs]'
	cd docs/notebooks && PATH="$(CURDIR)/$(BIN):$$PATH" NO_MKDOCS_2_WARNING=1 mkdocs build --quiet -f ../../mkdocs.yml

bench: $(STAMP)
	$(BIN)/python -m benchmarks.peers
	$(BIN)/python -m benchmarks.gateway_latency
	$(BIN)/python -m benchmarks.gateway_faults

clean:
	rm -rf build dist results
