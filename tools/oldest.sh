#!/usr/bin/env bash
# Print the oldest versions of all libraries that pyproject.toml allows, for Python 3.11, as
# constraints of pip:
#   tools/oldest.sh > oldest.txt
#   PIP_CONSTRAINT=$PWD/oldest.txt H5PY_VERSION=$(sed -n 's/^h5py==//p' oldest.txt) make test
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

tools=$(mktemp -d)
trap 'rm -rf "$tools"' EXIT
python3 -m venv "$tools"
"$tools/bin/python" -m pip install -q --disable-pip-version-check uv >&2
"$tools/bin/uv" pip compile pyproject.toml -q --extra mpi --extra dev --no-annotate --no-header \
    --python-version 3.11 --resolution lowest-direct |
    grep -v '^setuptools=='
echo "Cython<3.1  # with later ones h5py 3.12 does not compile"
