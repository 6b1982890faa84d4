#!/usr/bin/env bash
# An .ssp of spindle-drift in the program ecos, which is not Python:
# ssp_in_ecos.sh FILE.ssp STEP_S STOP_S. It writes FILE.csv to the working folder.
# PYTHON is the Python whose library and packages the FMUs use; ecospy and tbb are installed there.
set -euo pipefail
python=${PYTHON:-python}

# The wheel's program is not marked executable, and needs the library of the package tbb.
where=$("$python" -c 'from importlib.util import find_spec
print(find_spec("ecospy").submodule_search_locations[0] + "/binaries/ecos")')
tbb=$("$python" -c 'from importlib import metadata
print(next(f for f in metadata.files("tbb") if f.name == "libtbb.so.12").locate().resolve().parent)')
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
install -m 755 "$where" "$work/ecos"

# The Python library must be loaded before an FMU, and must find numpy.
library=$("$python" -c 'import sysconfig as s
print(s.get_config_var("LIBDIR") + "/" + s.get_config_var("INSTSONAME"))')
packages=$("$python" -c 'import sysconfig; print(sysconfig.get_path("platlib"))')
LD_LIBRARY_PATH=$tbb LD_PRELOAD=$library PYTHONPATH=$packages \
    "$work/ecos" simulate --path "$1" --stepSize "$2" --stopTime "$3" --parameterSet scenario
