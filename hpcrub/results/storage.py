"""Results ↔ HDF5. The only module that imports h5py.

How a file survives a kill at any moment:
- Rank 0 alone lays the whole file out in `NAME.hpcrub-part`: every dataset contiguous, at its final
  size, filled, sealed, flushed to the disk. Only then is it moved to its name. A half-made file
  never bears the name of a result, the old file is replaced in one step, and a disk too small is
  found at once.
- All ranks then open it. From here on only raw data changes, nothing that HDF5 needs in order to
  open the file. With several ranks the `mpio` driver writes straight through; the serial driver
  buffers, hence its flushes.
- The data of a sample is written before its status.
"""

import contextlib
import datetime
import importlib.metadata
import itertools
import os
import subprocess
from pathlib import Path

import h5py
import numpy as np

from hpcrub import __version__, studies
from hpcrub.config import schema as configuration
from hpcrub.errors import HpcrubError, InputError, reason
from hpcrub.results import ownership, seal
from hpcrub.results.layout import SAMPLE, TUNED

# HDF5's own locks would keep readers off a running study, and not every file system has them;
# `ownership.Lock` keeps a second writer off.
SERIAL = {"locking": False}
# in HDF5's superblock: set while the file is open to write
OPEN_FLAG, OPEN_FLAG_SIZE = 20, 4
LIBRARIES = ("numpy", "scipy", "numba", "h5py", "mpi4py")


def require_parallel():
    """Raises InputError when this h5py cannot write from several ranks."""
    if not h5py.get_config().mpi:
        raise InputError(
            "this h5py is built without MPI, which writing from several ranks needs: `make setup` "
            "builds one that has it (docs/cluster.md); one rank, without mpirun, works as it is"
        )


def lay_out(path, config, origin=None):
    """Create the result file at its final size, replacing one of that name in a single step.

    origin: attributes that say what computes its results, as `provenance`, by default this program.
    For one rank only. Raises InputError when the folder cannot be written or the disk is too small,
    and when the name is that of a file of somebody else.
    """
    path = os.path.realpath(path)
    part = Path(f"{path}.hpcrub-part")
    ownership.refuse_foreign(path)
    try:
        part.parent.mkdir(parents=True, exist_ok=True)
        part.unlink(missing_ok=True)  # of a job that was killed
        _reserve(part, studies.file_size(config))
        with h5py.File(part, "w", userblock_size=seal.BLOCK, **SERIAL) as file:
            _write_attributes(file, config, provenance() if origin is None else origin)
            for line in studies.layout(config):
                _create_dataset(file, line, studies.sizes(config))
            known = studies.find(config).constants(config)
            for name, values in known.items():
                file[name][...] = values
            _attach_scales(file, config)
            data = [file[line.name].id for line in studies.layout(config) if line.name not in known]
            data = [(d.get_offset(), d.get_storage_size()) for d in data if d.get_storage_size()]
            data.append((seal.BLOCK + OPEN_FLAG, OPEN_FLAG_SIZE))
        seal.write(part, __version__, data)
        ownership.move(part, path)
    except (OSError, RuntimeError) as error:  # h5py has both for a full disk
        with contextlib.suppress(OSError):
            part.unlink(missing_ok=True)
        raise InputError(f"cannot write {path}: {reason(error)}") from None


def _reserve(path, size):
    """Raises OSError when a new file of this size has no place, as by a quota: HDF5, when it cannot
    write, leaves objects behind that crash the process."""
    with open(path, "xb") as file:
        if hasattr(os, "posix_fallocate"):
            os.posix_fallocate(file.fileno(), 0, size)


def _write_attributes(file, config, origin):
    now = datetime.datetime.now(datetime.UTC)
    file.attrs["program"] = "hpcrub"
    file.attrs["program_version"] = __version__
    file.attrs["created"] = now.isoformat(timespec="seconds")
    file.attrs["config"] = config.to_yaml()
    file.attrs["seed"] = np.uint64(config.mistuning.seed)
    if found := studies.fingerprints(config):
        file.attrs["sources_sha256"] = " ".join(found.values())
    file.attrs.update(origin)


def provenance():
    """Commit and library versions, as attributes of the file."""
    found = {"hdf5_version": h5py.version.hdf5_version}
    if revision := _git_revision():
        found["git_revision"] = revision
    for library in LIBRARIES:
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            found[f"{library}_version"] = importlib.metadata.version(library)
    return found


def _git_revision():
    """Commit of a source checkout, with -dirty for changed files; None elsewhere."""
    folder = Path(__file__).resolve().parents[2]
    if not (folder / ".git").exists():
        return None
    command = ["git", "-C", str(folder), "describe", "--always", "--dirty", "--abbrev=40"]
    try:
        found = subprocess.run(command, capture_output=True, text=True, timeout=10, check=True)
    except (OSError, subprocess.SubprocessError):
        return None
    return found.stdout.strip()


def _create_dataset(file, line, length):
    """Create one dataset, allocated now; h5py's own call does not do that for scalars."""
    dtype = np.dtype(line.dtype)
    creation = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    creation.set_layout(h5py.h5d.CONTIGUOUS)
    creation.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    creation.set_fill_value(np.array(np.nan if dtype.kind == "f" else 0, dtype))
    shape = tuple(length[d] for d in line.dimensions)
    space = h5py.h5s.create_simple(shape) if shape else h5py.h5s.create(h5py.h5s.SCALAR)
    links = h5py.h5p.create(h5py.h5p.LINK_CREATE)
    links.set_create_intermediate_group(True)
    name, kind = line.name.encode(), h5py.h5t.py_create(dtype)
    dataset = h5py.Dataset(h5py.h5d.create(file.id, name, kind, space, creation, lcpl=links))
    dataset.attrs["units"] = line.units
    dataset.attrs["description"] = line.description
    for axis, dimension in enumerate(line.dimensions):
        dataset.dims[axis].label = dimension


def _attach_scales(file, config):
    scales = studies.find(config).SCALES
    for line in studies.layout(config):
        dataset = file[line.name]
        for axis, dimension in enumerate(line.dimensions):
            # {group}: a scale of its own in every group, such as the blocks of the statistics
            name = scales.get(dimension, "").format(group=line.name.rpartition("/")[0])
            if name and name != line.name:
                if not file[name].is_scale:
                    file[name].make_scale(name.rpartition("/")[2])
                dataset.dims[axis].attach_scale(file[name])
            if dimension == "percentile":
                dataset.attrs["percentiles"] = config.convergence.percentiles


def check(path, config=None):
    """Refuse what is not a sound result file of this version, and of `config` when given.

    Raises InputError that says what is wrong.
    """
    path = Path(path)
    try:
        if not path.is_file():
            raise InputError(f"{path} is no file" if path.exists() else f"{path} does not exist")
        seal.check(path, __version__)
        with h5py.File(path, "r", **SERIAL) as file:
            stored = _stored_config(path, file)
            if config is not None:
                _check_config(path, stored, config)
            _check_layout(path, file, stored)
    except HpcrubError:
        raise
    except OSError as error:
        raise InputError(f"cannot read {path}: {reason(error)}") from None
    except Exception as error:  # whatever h5py raises on what only a forger can have sealed
        raise InputError(f"{path} is damaged ({reason(error)})") from None


def check_sources(path, config):
    """Refuse to go on with a sound result file whose sources have changed since it was begun.

    Raises InputError that names the source.
    """
    found = studies.fingerprints(config)
    with h5py.File(path, "r", **SERIAL) as file:
        stored = str(file.attrs.get("sources_sha256", "")).split()
    for source, before in itertools.zip_longest(found, stored):
        if before != found.get(source):
            raise InputError(
                f"sources: {source} has changed since {path} was begun; --overwrite begins anew"
            )


def _check_config(path, stored, config):
    differences = configuration.differences(stored, config)
    if differences:
        more = f" (and {len(differences) - 1} more)" if len(differences) > 1 else ""
        n_samples = config.mistuning.samples
        if len(differences) == 1 and stored.mistuning.samples < n_samples:
            program = f"python -m hpcrub merge --samples {n_samples}"
            more = f"; {program} NEW.h5 {path} makes room for them"
        raise InputError(f"{path} has another configuration: {differences[0]}{more}")


def _stored_config(path, file):
    try:
        return configuration.Config.from_yaml(str(file.attrs["config"]))
    except (InputError, KeyError) as error:
        raise _other_state(path, file, f"its configuration cannot be read: {error}") from None


def _check_layout(path, file, config):
    length = studies.known_sizes(config)
    for line in studies.layout(config):
        dataset = _dataset(file, line.name)
        if dataset is None:
            raise _other_state(path, file, f"it has no dataset {line.name}")
        # what only the sources told is here the same in all datasets
        length = dict(zip(line.dimensions, dataset.shape, strict=False)) | length
        shape = tuple(length.get(d) for d in line.dimensions)
        plist = dataset.id.get_create_plist()
        plain = plist.get_layout() == h5py.h5d.CONTIGUOUS and plist.get_external_count() == 0
        if dataset.shape != shape or dataset.dtype != np.dtype(line.dtype) or not plain:
            raise _other_state(
                path,
                file,
                f"{line.name} is {dataset.dtype}{list(dataset.shape)}, "
                f"not {np.dtype(line.dtype)}{list(shape)}",
            )


def _dataset(file, name):
    """A dataset of this file itself, None when the name leads elsewhere or nowhere."""
    parts = name.split("/")
    for end in range(1, len(parts) + 1):
        if not isinstance(file.get("/".join(parts[:end]), getlink=True), h5py.HardLink):
            return None
    return found if isinstance(found := file[name], h5py.Dataset) else None


def _other_state(path, file, difference):
    """The error of a file that is as it was written, but not as this program writes it."""
    revision = str(file.attrs.get("git_revision", "unknown"))[:50]
    return InputError(
        f"{path} was written by another state of hpcrub (revision {revision}): {difference}"
    )


def _is_root(comm):
    return comm is None or comm.rank == 0


class ResultFile:
    """An open result file. Reads and writes are independent: any rank, any time."""

    def __init__(self, path, comm=None, mode="r"):
        """Open a file that `check` has found sound; collective with several ranks."""
        self.path = Path(path)
        parallel = comm is not None and comm.size > 1
        try:
            if parallel:
                self._file = h5py.File(path, mode, driver="mpio", comm=comm)
            else:
                self._file = h5py.File(path, mode, **SERIAL)
        except OSError as error:
            raise InputError(f"cannot open {path}: {reason(error)}") from None
        # to find the file again, should somebody take its name away
        self._kept = os.open(path, os.O_RDONLY) if mode != "r" and _is_root(comm) else None
        self._flush = self._file.flush if mode != "r" and not parallel else lambda: None
        self.config = _stored_config(path, self._file)
        lines = studies.layout(self.config)
        self._datasets = {line.name: self._file[line.name] for line in lines}

    @classmethod
    def open(cls, path, config=None, comm=None, mode="r"):
        """Check a file and open it. Raises InputError as `check`."""
        check(path, config)
        return cls(path, comm, mode)

    def read(self, name, where=()):
        """Values of a dataset, or of the part `where`, as a numpy array or scalar."""
        return self._datasets[name][where]

    def shape(self, name):
        """Length of every dimension of a dataset."""
        return self._datasets[name].shape

    def status(self):
        """Status of every sample, (V, n) uint8, or of every task, (T,)."""
        return self.read("status" if studies.is_tasks(self.config) else "samples/status")

    def attributes(self):
        """Attributes of the root: configuration, versions, time."""
        return dict(self._file.attrs)

    def tuned(self):
        """Results of the tuned disk by name, None when they are not complete."""
        names = {name: f"tuned/{name}" for name in TUNED}
        values = {name: self.read(at) for name, at in names.items() if at in self._datasets}
        return values if np.isfinite(values["linear_amplitude_m"]) else None

    def write_tuned(self, values):
        """Write the results of the tuned disk, a dict by the names in `TUNED`; one rank."""
        self.write(self._present("tuned", TUNED, values), ())

    def write_sample(self, level, sample, values):
        """Write one sample, a dict by the names in `SAMPLE` (`status` included, others may be
        missing in a failed one); one rank. The status goes last.

        Raises HpcrubError when the file cannot be written.
        """
        present = self._present("samples", SAMPLE, values)
        status = {"samples/status": present.pop("samples/status")}
        self.write(present, (level, sample))
        self.write(status, (level, sample))

    def _present(self, group, names, values):
        """{dataset: value} of those that this file has, in the order of names."""
        pairs = ((f"{group}/{name}", values[name]) for name in names if name in values)
        return {name: value for name, value in pairs if name in self._datasets}

    def write_statistics(self, kind, level, running, intervals):
        """Write RunningPercentiles and Intervals of one level; blocks beyond its last become NaN;
        one rank."""
        lines = running._asdict() | intervals._asdict()
        lines.pop("samples_seen")  # known since the file was laid out
        for name, values in lines.items():
            dataset = f"statistics/{kind}/{name}"
            padded = np.full(self._datasets[dataset].shape[1:], np.nan)
            padded[:, : values.shape[1]] = values
            self.write({dataset: padded}, (level,))

    def write(self, values, where):
        """Write {dataset: values} at one place, in this order; one rank.

        Raises HpcrubError when the file cannot be written.
        """
        try:
            for name, value in values.items():
                self._datasets[name][where] = value
            self._flush()
        except (OSError, RuntimeError) as error:
            raise HpcrubError(f"cannot write {self.path}: {reason(error)}") from None

    def close(self):
        """Close the file; collective with several ranks."""
        self._file.close()

    def put_back(self):
        """Copy a file just written to its name, if somebody has removed or moved it; one rank.

        Returns whether somebody has. Raises HpcrubError when another file has taken the name, or it
        cannot be written.
        """
        return ownership.put_back(self._kept, self.path)
