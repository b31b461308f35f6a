"""Reading and writing of result files. Only this module imports h5py.

HDF5's own checksums find damage of its metadata. The format of HDF5 1.8 has checksums for all
metadata but texts of variable length: hence `LIBVER`, and attributes of fixed length.

How a file survives a kill at any moment: rank 0 lays it out, whole and flushed to the disk, in
`NAME.hpcrub-part`, and then moves it to its name. From here on only raw data changes, that of a
sample before its status. The driver `mpio` of several ranks writes straight through; the serial
one buffers, hence its flushes.
"""

import contextlib
import datetime
import os
import shutil
import stat
from collections.abc import Callable, Iterable, Iterator
from itertools import accumulate
from pathlib import Path
from typing import Any, Self

import h5py
import numpy as np

from hpcrub import __version__
from hpcrub.config.schema import Config
from hpcrub.errors import HpcrubError, InputError, WriteError, reason, refuse_endless
from hpcrub.results import ownership, provenance
from hpcrub.results.layout import NUMBER, Plan, file_size

# HDF5's own locks would keep readers off a running study, and not every file system has them;
# `ownership.Lock` keeps a second writer off. Reading is done with HDF5's default, as by xarray: one
# process cannot open a file in both ways.
SERIAL = {"locking": False}
OTHER_LOCKING = "locking flag values don't match"
LIBVER = {"libver": ("v108", "v108")}  # v110 leaves a file that nobody can open after kill -9
LINKS = h5py.SoftLink, h5py.ExternalLink
DEFLATED = 1100  # largest factor by which deflate can compress data
# exceptions of h5py on damage; IndexError is not among them, it is an error of this program
DAMAGE = (OSError, RuntimeError, KeyError, ValueError, TypeError, OverflowError)


def require_parallel() -> None:
    """Raise InputError when this h5py cannot write from several ranks."""
    if not h5py.get_config().mpi:
        raise InputError(
            "this h5py is built without MPI, which writing from several ranks needs: `make setup` "
            "builds one that has it (docs/cluster.md); one rank, without mpirun, works as it is"
        )


def lay_out(path: str | Path, plan: Plan) -> None:
    """Create the result file at its final size, replacing one of that name in a single step.

    Only one rank may call it. Raises InputError when the folder cannot be written, the disk is too
    small, or a file of that name is no result of hpcrub.
    """
    path = os.path.realpath(path)
    refuse_foreign(path)
    try:
        with ownership.replacing(path) as part:
            ownership.reserve(part, file_size(plan.lines, plan.lengths))
            with h5py.File(part, "w", **LIBVER, **SERIAL) as file:
                _write_attributes(file, plan)
                for line in plan.lines:
                    _create_dataset(file, line, plan.lengths)
                for name, values in plan.values.items():
                    file[name][...] = values
                _attach_scales(file, plan)
            ownership.reserve(part, part.stat().st_size, "r+b")  # holes of texts not written yet
    except (OSError, RuntimeError) as error:  # h5py raises both on a full disk
        raise InputError(f"cannot write {path}: {reason(error)}") from None


def _text(words: str) -> Any:
    """Return a text as an attribute of fixed length, which HDF5's checksums cover."""
    content = words.encode()
    return np.array(content, h5py.string_dtype("utf-8", max(1, len(content))))


def _write_attributes(file: Any, plan: Any) -> None:
    texts = {
        "program": "hpcrub",
        "created": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "config": plan.config.to_yaml(),
        "hdf5_version": h5py.version.hdf5_version,
        **provenance.origin(),
        **plan.attributes,
    }
    for name, value in texts.items():
        file.attrs[name] = _text(value) if isinstance(value, str) else value
    file.attrs["layout"] = NUMBER
    file.attrs["seed"] = np.uint64(plan.config.mistuning.seed)


def note_program(path: str | Path) -> None:
    """Add this program to the attributes of a file that another program has begun.

    It changes a copy, which then replaces the file: a kill harms nothing. Raises OSError.
    """
    path = os.path.realpath(path)
    with ownership.replacing(path) as part:
        shutil.copyfile(path, part)
        with h5py.File(part, "r+", **LIBVER, **SERIAL) as file:
            for name, value in provenance.origin().items():
                known = str(_words(file.attrs.get(name, value))).split(", ")
                file.attrs[name] = _text(", ".join(dict.fromkeys([*known, value])))


def _create_dataset(file: Any, line: Any, length: Any) -> None:
    """Create one dataset and allocate it now, which h5py's own call does not do for scalars."""
    dtype = np.dtype(line.dtype)
    creation = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    creation.set_layout(h5py.h5d.CONTIGUOUS)
    creation.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    if dtype.kind != "S":
        creation.set_fill_value(np.array(np.nan if dtype.kind == "f" else 0, dtype))
    shape = tuple(length[d] for d in line.dimensions)
    space = h5py.h5s.create_simple(shape) if shape else h5py.h5s.create(h5py.h5s.SCALAR)
    links = h5py.h5p.create(h5py.h5p.LINK_CREATE)
    links.set_create_intermediate_group(True)
    name, kind = line.name.encode(), h5py.h5t.py_create(dtype, logical=True)
    dataset = h5py.Dataset(h5py.h5d.create(file.id, name, kind, space, creation, lcpl=links))
    dataset.attrs["units"] = _text(line.units)
    dataset.attrs["long_name"] = _text(line.description)


def _attach_scales(file: Any, plan: Any) -> None:
    """Attach to every axis its scale, which names the dimension for netCDF."""
    for line in plan.lines:
        for axis, dimension in enumerate(line.dimensions):
            name = plan.scales[dimension]
            if not file[name].is_scale:
                file[name].make_scale(name.rpartition("/")[2])
            if name != line.name:
                file[line.name].dims[axis].attach_scale(file[name])


def _is_ours(path: Any) -> Any:
    try:
        with _open_to_read(path) as file:
            return str(_words(file.attrs["program"])) == "hpcrub"
    except BlockingIOError:  # it may be, and another program has it open
        raise
    except DAMAGE:
        return False


def refuse_foreign(path: str | Path) -> None:
    """Raise InputError unless there is no file, or it is empty, or a result file of hpcrub."""
    path = Path(os.path.realpath(path))
    try:
        kind = path.stat().st_mode if os.path.lexists(path) else None
        if kind is None or (stat.S_ISREG(kind) and (not path.stat().st_size or _is_ours(path))):
            return
    except OSError as error:
        raise InputError(f"cannot replace {path}: {reason(error)}") from None
    raise InputError(
        f"{path} is not a result file of hpcrub, or damaged, and is not replaced; "
        "move it away, or choose another output"
    )


class ResultFile:
    """An open result file. Reads and writes are independent: any rank, any time.

    A file of any version opens if this program knows its layout. `studies.open_result` checks, too,
    that the file holds everything that its study needs.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        comm: Any = None,
        mode: str = "r",
        check: Callable[[Self], None] = lambda file: None,
    ) -> None:
        """Open a file; collective with several ranks.

        comm: MPI communicator of the ranks that open it, None for one process.
        mode: "r" to read, "r+" to write too.
        check: called with the open file, which an exception from it closes.
        Raises InputError when it is no result file, or its layout is unknown to this program.
        """
        self.path = Path(path).expanduser()
        parallel = comm is not None and comm.size > 1
        refuse_endless(self.path)
        try:
            if mode == "r" and not parallel:
                self._file = _open_to_read(self.path)
            else:
                how = {"driver": "mpio", "comm": comm} if parallel else SERIAL
                self._file = h5py.File(self.path, mode, **LIBVER, **how)
        except OSError as error:
            raise InputError(f"cannot open {self.path} as HDF5: {reason(error)}") from None
        self._flush = self._file.flush if mode != "r" and not parallel else lambda: None
        self._datasets: dict[str, h5py.Dataset] = {}
        try:
            self._check_layout()
            self.config = self._config()
            check(self)
        except BaseException:
            self._file.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _check_layout(self) -> None:
        attributes = self.attributes
        if str(attributes.get("program")) != "hpcrub":
            raise InputError(f"{self.path} is not a result file of hpcrub")
        number = attributes.get("layout", 1)
        if str(number) != str(NUMBER):
            by = f"(hpcrub {attributes.get('program_version')!s:.20}), this hpcrub {__version__}"
            raise InputError(f"{self.path} has layout {number!s:.20} {by} reads layout {NUMBER}")

    def _config(self) -> Any:
        try:
            return Config.from_yaml(str(self.attributes["config"]))
        except (InputError, KeyError) as error:
            by = f"{self.path} was written by {self.written_by()}"
            raise InputError(f"{by}: its configuration cannot be read: {error}") from None

    def written_by(self) -> str:
        """Return version and revision of the program that laid the file out, for messages."""
        known = self.attributes
        version, revision = (known.get(n, "?") for n in ("program_version", "git_revision"))
        return f"hpcrub {version!s:.20} (revision {revision!s:.50})"

    def names(self) -> list[str]:
        """Return the names of all datasets in the file itself, those that a user added included."""
        with self._damage():
            return [name for name, dataset in _items_in(self._file) if dataset is not None]

    def require_own(self, names: Iterable[str]) -> None:
        """Raise InputError for datasets whose data is not in the file itself; collective.

        Opening a dataset of length zero changes metadata, on which all ranks must agree at closing.
        """
        with self._damage():
            for name in names:
                for path in accumulate(name.split("/"), "{}/{}".format):  # also of its groups
                    if isinstance(self._file.get(path, getlink=True), LINKS):
                        _require_own(self.path, path, None)
                if not isinstance(self._file.get(name), h5py.Dataset):
                    by = f"{self.written_by()} wrote it, or it is damaged"
                    raise InputError(f"{self.path} has no dataset {name}: {by}")
                _require_own(self.path, name, self._dataset(name))

    def __contains__(self, name: str) -> bool:
        with contextlib.suppress(InputError):
            return bool(self._dataset(name))
        return False

    @contextlib.contextmanager
    def _damage(self) -> Iterator[None]:
        """Turn whatever HDF5 finds wrong with the file into an InputError of one line."""
        if not self._file:
            raise InputError(f"{self.path} is closed; read it within `with`, or open it again")
        try:
            yield
        except HpcrubError:
            raise
        except MemoryError:
            raise InputError(f"{self.path} holds more than this machine's memory") from None
        except DAMAGE as error:
            raise InputError(f"{self.path} is damaged ({reason(error)})") from None

    def _dataset(self, name: str) -> Any:
        if name not in self._datasets:
            with self._damage():
                item = self._file.get(name)
            if not isinstance(item, h5py.Dataset):
                raise InputError(f"{self.path} has no dataset {name}")
            self._datasets[name] = item
        return self._datasets[name]

    def read(self, name: str, where: Any = ()) -> Any:
        """Return the values of a dataset, or of its part `where`, as a numpy array or scalar."""
        dataset = self._dataset(name)
        with self._damage():
            return dataset[where]

    def shape(self, name: str) -> tuple[int, ...]:
        """Return the length of every dimension of a dataset."""
        return self._dataset(name).shape

    def dtype(self, name: str) -> np.dtype:
        """Return the type of the values of a dataset."""
        return self._dataset(name).dtype

    def dimensions(self, name: str) -> tuple[str, ...]:
        """Name of each axis of a dataset: of its scale, else its label, else `axis_NUMBER`."""
        dataset = self._dataset(name)
        with self._damage():
            if dataset.is_scale:
                return (name,)
            scales = [axis[0].name if len(axis) else None for axis in dataset.dims]
            return tuple(  # the scale of a damaged file may have no name
                scale.lstrip("/") if scale else axis.label or f"axis_{number}"
                for number, (scale, axis) in enumerate(zip(scales, dataset.dims, strict=True))
            )

    @property
    def attributes(self) -> dict[str, Any]:
        """Attributes of the file: configuration, versions of program and libraries, seed, time."""
        return self.attributes_of("/")

    def attributes_of(self, name: str) -> dict[str, Any]:
        """Attributes of a dataset."""
        item = self._file if name == "/" else self._dataset(name)
        with self._damage():
            hidden = "DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME"
            return {key: _words(item.attrs[key]) for key in item.attrs if key not in hidden}

    @property
    def warnings(self) -> list[str]:
        """Warnings of the study before it began, a line each."""
        return [line for line in str(self.attributes.get("warnings", "")).splitlines() if line]

    @property
    def status(self) -> np.ndarray:
        """Of every sample (V, n), of other studies every task (T,), 0 pending, 1 done, 2 failed."""
        return self.read("status" if "status" in self else "samples/status")

    def write(self, values: dict[str, Any], where: Any) -> None:
        """Write {dataset: values} at the index `where`, in this order. Raises WriteError."""
        try:
            for name, value in values.items():
                self._dataset(name)[where] = value
            self._flush()
        except (OSError, RuntimeError) as error:
            why = ownership.unwritable(error, self.path)
            raise WriteError(f"cannot write {self.path}: {why}") from None

    def close(self) -> None:
        """Close the file; collective with several ranks."""
        self._file.close()


def _items_in(group: Any, prefix: str = "") -> Iterator[Any]:
    """Yield (name, dataset) of all datasets below a group, (name, None) of links, not followed."""
    # look a known name up instead: HDF5 may crash when it lists a damaged group
    for name in group:
        linked = isinstance(group.get(name, getlink=True), LINKS)
        item = None if linked else group[name]
        if isinstance(item, h5py.Group):
            yield from _items_in(item, f"{prefix}{name}/")
        elif linked or isinstance(item, h5py.Dataset):
            yield f"{prefix}{name}", item


def _require_own(path: Any, name: str, dataset: Any) -> None:
    if dataset is None or dataset.external or dataset.is_virtual:
        raise InputError(f"{path}: {name} is a link, or its data is stored elsewhere")


def read_arrays(path: str | Path) -> dict[str, Any]:
    """Read all datasets by name, texts as str. Raises InputError for links, OSError for damage."""
    with h5py.File(path, "r", **SERIAL) as file:
        return {name: _array(path, name, dataset) for name, dataset in _items_in(file)}


def _array(path: Any, name: str, dataset: Any) -> Any:
    _require_own(path, name, dataset)
    held = dataset.id.get_storage_size()
    if dataset.nbytes > DEFLATED * held:
        raise OSError(f"{name}: claims {dataset.nbytes:,} bytes, and holds {held:,}")
    text = h5py.check_string_dtype(dataset.dtype)
    return np.array(dataset.asstr("utf-8")[()]) if text else dataset[()]


def write_arrays(path: str | Path, arrays: dict[str, Any]) -> None:
    """Write arrays by name into a new HDF5 file, compressed. Raises OSError."""
    small = {"compression": "gzip", "compression_opts": 9, "shuffle": True}
    with h5py.File(path, "w", **SERIAL) as file:
        for name, values in ((name, np.asarray(values)) for name, values in arrays.items()):
            if values.dtype.kind == "U":
                file[name] = values.item()
            else:
                file.create_dataset(name, data=values, **(small if values.ndim else {}))


def _open_to_read(path: Any) -> Any:
    try:
        return h5py.File(path, "r")
    except OSError as error:  # this process has it open to write, or the file system has no locks
        if OTHER_LOCKING in str(error) or error.errno in ownership.NO_LOCKS:
            return h5py.File(path, "r", **SERIAL)
        raise


def _words(value: Any) -> Any:
    return value.decode(errors="replace") if isinstance(value, bytes) else value
