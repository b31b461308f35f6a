"""Build a wheel of h5py with as many processes of Cython as there are cores, where h5py takes one.

    python tools/build_h5py.py SOURCE FOLDER

SOURCE is the unpacked h5py, FOLDER gets the wheel. Cython takes half of the time of the build.
"""

import functools
import os
import runpy
import sys

import Cython.Build

MOST = 8  # processes: others use a login node, too


def main(source, folder):
    cores = min(len(os.sched_getaffinity(0)), MOST)
    Cython.Build.cythonize = functools.partial(Cython.Build.cythonize, nthreads=cores)
    folder = os.path.abspath(folder)
    os.chdir(source)
    sys.path.insert(0, os.getcwd())
    sys.argv = ["setup.py", "bdist_wheel", "--dist-dir", folder]
    runpy.run_path("setup.py", run_name="__main__")


if __name__ == "__main__":  # Cython's processes import this file, too
    main(*sys.argv[1:])
