#!/usr/bin/env bash
# Set up hpcrub in .venv with an h5py that writes one HDF5 file from all MPI ranks.
# Does only what is missing. Variables, all optional:
#   PYTHON     interpreter of the virtual environment (python3)
#   APT        yes: install missing system packages as root (default); no: never, only name them
#   HDF5_DIR   prefix of a parallel HDF5 >= 1.10.7 (default: Debian's, found by pkg-config)
#   MPICC      compiler wrapper of the MPI to use (mpicc)
#   H5PY_VERSION  release of h5py that is built (3.16.0)
#   EXTRAS     extras of pyproject.toml to install: mpi, what a run needs (default), or mpi,dev
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

PYTHON=${PYTHON:-python3}
APT=${APT:-yes}
HDF5_DIR=${HDF5_DIR:-}
MPICC=${MPICC:-mpicc}
H5PY_VERSION=${H5PY_VERSION:-3.16.0}
EXTRAS=${EXTRAS:-mpi}
HDF5_PKG=hdf5-openmpi
VENV_PYTHON=.venv/bin/python
LOG=.venv/setup.log

say() { printf 'setup: %s\n' "$*"; }
die() { printf 'setup: error: %s\n' "$*" >&2; exit 1; }
logged() {  # run a command with its output in the log, which is shown only when it fails
    printf '+ %s\n' "$*" >>"$LOG"
    "$@" >>"$LOG" 2>&1 || { tail -n 25 "$LOG" >&2; die "failed: $* (all output: $LOG)"; }
}
pip() { logged "$VENV_PYTHON" -m pip --disable-pip-version-check "$@"; }

# --- system packages ------------------------------------------------------------------------

missing_packages() {  # one line per missing piece: its Debian package, then what was looked for
    command -v gcc >/dev/null || echo "gcc (command gcc)"
    [ -e /usr/include/stdio.h ] || echo '#include <stdio.h>' | gcc -E - >/dev/null 2>&1 ||
        echo "libc6-dev (header stdio.h)"
    command -v mpirun >/dev/null || echo "openmpi-bin (command mpirun)"
    command -v "$MPICC" >/dev/null || echo "libopenmpi-dev (command $MPICC)"
    if [ -z "$HDF5_DIR" ]; then
        command -v pkg-config >/dev/null || echo "pkg-config (command pkg-config)"
        pkg-config --exists "$HDF5_PKG" 2>/dev/null ||
            echo "libhdf5-openmpi-dev (parallel HDF5; or set HDF5_DIR)"
    fi
    "$PYTHON" -c 'import ensurepip, venv' 2>/dev/null ||
        echo "python3-venv (modules venv and ensurepip of $PYTHON)"
    "$PYTHON" -c 'import os, sysconfig as s; os.stat(s.get_path("include") + "/Python.h")' \
        2>/dev/null || echo "python3-dev (header Python.h of $PYTHON)"
}

install_missing() {
    local missing packages
    missing=$(missing_packages)
    [ -n "$missing" ] || return 0
    packages=$(cut -d' ' -f1 <<<"$missing" | paste -sd' ')
    if [ "$APT" = no ] || [ "$(id -u)" != 0 ] || ! command -v apt-get >/dev/null; then
        printf 'setup: these are missing:\n%s\n' "$(sed 's/^/  /' <<<"$missing")" >&2
        die "install them (Debian, Ubuntu: sudo apt-get install $packages) or load their modules"
    fi
    say "installing system packages: $packages"
    export DEBIAN_FRONTEND=noninteractive
    apt-get update -q >/dev/null || say "apt-get update failed; going on with the lists there are"
    # shellcheck disable=SC2086  # one word per package
    apt-get install -q -y --no-install-recommends $packages >/dev/null || die "apt-get failed"
    missing=$(missing_packages)
    [ -z "$missing" ] || die "still missing after apt-get: $(paste -sd';' <<<"$missing")"
}

# --- virtual environment --------------------------------------------------------------------

make_venv() {
    if [ -e .venv ]; then
        "$VENV_PYTHON" -m pip --version >/dev/null 2>&1 ||
            die ".venv is not a working virtual environment with pip; remove it and try again"
        return
    fi
    "$PYTHON" -c 'import sys; sys.exit(sys.version_info < (3, 11))' ||
        die "$PYTHON is $("$PYTHON" --version 2>&1); Python 3.11 or newer is needed (PYTHON=...)"
    say "creating .venv with $("$PYTHON" --version)"
    "$PYTHON" -m venv .venv || die "$PYTHON cannot create a virtual environment"
}

# --- h5py with parallel HDF5 ----------------------------------------------------------------

toolchain() {  # what a compiled h5py depends on
    "$VENV_PYTHON" -c 'import sysconfig as s; print(s.get_config_var("SOABI"), s.get_platform())'
    "$MPICC" -show
    mpirun --version | head -n 1
    if [ -n "$HDF5_DIR" ]; then
        echo "$HDF5_DIR"
        grep -hs 'define H5_VERS_INFO' "$HDF5_DIR"/include/H5public.h || true
    else
        pkg-config --modversion "$HDF5_PKG"
        pkg-config --cflags --libs "$HDF5_PKG"
    fi
}

has_parallel_h5py() {
    [ -e "$VENV_PYTHON" ] && "$VENV_PYTHON" - "$H5PY_VERSION" 2>/dev/null <<'PY'
import sys
import h5py
sys.exit(not (h5py.get_config().mpi and h5py.__version__ == sys.argv[1]))
PY
}

build_h5py() {  # $1: folder for the wheel
    local config source
    say "building h5py $H5PY_VERSION against parallel HDF5 (about a minute, once)"
    # Its build must use the mpi4py installed here: in isolation it would compile another one,
    # which takes tens of gigabytes of memory. pip's own cache ignores HDF5_MPI and is not used.
    config=$(mktemp)
    source=$(mktemp -d)
    printf '[build_ext]\nparallel = 4\n' >"$config"
    # -O0 halves the time of the compiler; a write takes 30 us longer than with -O1, of about 100
    export HDF5_MPI=ON CC="$MPICC" H5PY_SETUP_REQUIRES=0 CFLAGS="-O0 -g0" DIST_EXTRA_CONFIG="$config"
    if [ -n "$HDF5_DIR" ]; then
        export HDF5_DIR
    else
        unset HDF5_DIR
        export HDF5_PKGCONFIG_NAME="$HDF5_PKG"
    fi
    pip download --no-deps --no-binary=h5py --no-build-isolation --dest "$source" \
        "h5py==$H5PY_VERSION"
    logged tar -x -f "$source"/h5py-*.tar.gz -C "$source" --strip-components=1
    logged "$VENV_PYTHON" tools/build_h5py.py "$source" "$1"
    rm -rf "$config" "$source"
}

install_h5py() {
    local made_with key folder part
    made_with=$(toolchain)
    key=$(sha256sum <<<"$made_with" | cut -c1-12)
    if has_parallel_h5py && [ "$(cat .venv/h5py-key 2>/dev/null || echo "$key")" = "$key" ]; then
        echo "$key" >.venv/h5py-key
        return
    fi
    folder=${XDG_CACHE_HOME:-$HOME/.cache}/hpcrub/wheels/h5py-$H5PY_VERSION-$key
    if ! ls "$folder"/h5py-*.whl >/dev/null 2>&1; then
        mkdir -p "$folder"
        part=$(mktemp -d "$folder.part-XXXXXX")  # of its own: two set-ups may build at once
        echo "$made_with" >"$part/made-with.txt"
        (build_h5py "$part") || { rm -rf "$part"; wait "$OTHERS" || true; return 1; }
        mv -f "$part"/* "$folder"  # each file whole or not at all, also while another one reads it
        rmdir "$part"
    else
        say "using the h5py wheel in $folder"
    fi
    wait "$OTHERS" || die "the other packages could not be installed"
    pip install --no-compile --force-reinstall --no-deps "$folder"/h5py-*.whl
    has_parallel_h5py || die "h5py was built but does not load with MPI: $(
        "$VENV_PYTHON" -c 'import h5py; print("mpi is", h5py.get_config().mpi)' 2>&1 | tail -n 1)"
    echo "$key" >.venv/h5py-key
}

# --- the other packages -----------------------------------------------------------------------

other_packages() {  # all but h5py, of which pip would install one without MPI, and what needs it
    "$VENV_PYTHON" - "$EXTRAS" <<'PY'
import re, sys, tomllib
project = tomllib.load(open("pyproject.toml", "rb"))["project"]
extras, todo = project["optional-dependencies"], sys.argv[1].split(",")
lines = list(project["dependencies"])
while todo:
    for line in extras[todo.pop()]:
        own = re.fullmatch(r"hpcrub\[(.*)\]", line)
        todo += own[1].split(",") if own else []
        lines += [] if own else [line]
print("\n".join(line for line in lines if not line.startswith(("h5py", "h5netcdf"))))
PY
}

start=$SECONDS
install_missing
make_venv
# First what the build of h5py needs, with numba, which may ask for another numpy. The others are
# installed while h5py is built. Nothing is compiled but what is imported, at the end.
pip install --no-compile numpy numba 'mpi4py>=4.0.1' 'setuptools>=77.0.1' 'Cython>=3,<4' pkgconfig \
    packaging
other_packages >.venv/others.txt
(LOG=.venv/setup-others.log; pip install --no-compile --requirement .venv/others.txt) &
OTHERS=$!
install_h5py
wait "$OTHERS" || die "the other packages could not be installed"
pip install --no-compile --no-build-isolation --editable ".[$EXTRAS]"
has_parallel_h5py || die "h5py lost its parallel HDF5 to another package; see $LOG"
logged env -u PYTHONDONTWRITEBYTECODE "$VENV_PYTHON" -c \
    'import hpcrub.commands.run, hpcrub.commands.report, hpcrub.plot'
touch .venv/set-up
[ "${EXTRAS%dev}" = "$EXTRAS" ] || touch .venv/set-up-dev
say "ready after $((SECONDS - start)) s: h5py $H5PY_VERSION with parallel HDF5 in .venv"
