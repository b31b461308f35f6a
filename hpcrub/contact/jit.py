"""One compilation policy for every numba kernel of the project.

Compiled code is cached in a folder whose name depends on the package's place and sources, inside
that of ``NUMBA_CACHE_DIR`` if this is set: numba itself only checks the file of the function that
it compiles, and would run stale code after a change in ``lanes.py``. Without a writable folder,
every run compiles anew.
"""

import contextlib
import hashlib
import inspect
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
from llvmlite.binding import parse_bitcode
from numba.core import types
from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder, compile_result
from numba.core.dispatcher import Dispatcher
from numba.core.imputils import lower_getattr_generic
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.cpython.tupleobj import namedtuple_getattr

from hpcrub.contact import simd  # noqa: F401, teaches numba what `lanes` are
from hpcrub.contact.groups import Group, borrowed_member
from hpcrub.contact.machine import shape

COMPILED_ROOMS = "contact", "model", "response"  # rooms with code that numba compiles


def _cache_folder() -> str:
    """Folder for compiled code; "" where no folder can be written."""
    try:
        own = os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME")
        folder = Path(own or Path.home() / ".cache") / "hpcrub" / "jit" / _name()
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    except (OSError, RuntimeError):  # read-only, or no home at all
        return ""
    return str(folder) if os.access(folder, os.W_OK) else ""


def _name() -> Any:
    """Name of the cache: a hash of numba's version, the kernel's shape and all sources."""
    digest = hashlib.sha256(f"{numba.__version__} {shape()}".encode())
    package = Path(os.path.abspath(__file__)).parents[1]
    for room in COMPILED_ROOMS:
        for source in sorted((package / room).rglob("*.py")):
            digest.update(f"{source} {source.stat().st_mtime_ns}\n".encode())
            digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


numba.config.CACHE_DIR = _cache_folder()  # type: ignore[attr-defined]


class _Cache(FunctionCache):
    """numba's cache of one function, with own files for every signature.

    Processes that compile different signatures at once would lose each other's entries in a common
    index. An index also names the classes of laws and observers of other packages, so that a
    program without them could not read it. The name of the files depends on the modules and sources
    of these; the name of the folder does not.
    """

    def _take_files(self, sig: Any) -> None:
        """Select the cache files for a signature."""
        names = "".join([str(sig), *sorted(_foreign_sources(sig))])
        base = f"{self._impl.filename_base}-{hashlib.sha256(names.encode()).hexdigest()[:16]}"
        stamp = self._impl.locator.get_source_stamp()
        self._cache_file = IndexDataCacheFile(self._cache_path, base, stamp)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Compiled code of a signature from the cache, or None, also where files are damaged."""
        self._take_files(sig)
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # pickle may raise anything on a file that was cut
            with contextlib.suppress(OSError):
                self._cache_file.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Write compiled code to the cache; if that fails, the next run compiles anew."""
        self._take_files(sig)
        with contextlib.suppress(Exception):  # a damaged index that could not be flushed, too
            super().save_overload(sig, data)


class _InnerLibrary(JITCodeLibrary):
    """Code of an inner function, which LLVM optimises within the callers alone.

    numba would optimise every function with all that it calls, and make machine code of it, which
    takes a third of the time to compile a kernel.
    """

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Address of a function's machine code: there is none."""
        self._ensure_finalized()
        return 0

    def serialize_using_object_code(self) -> Any:
        """Name, kind and bitcode of the library, for the cache."""
        return self.serialize_using_bitcode()

    @property
    def codegen(self) -> "_InnerLibrary":
        """What numba asks to set the environment of a function."""
        return self

    def set_env(self, name: str, environment: Any) -> None:
        """Leave the environment unset, which only machine code reads."""


class _InnerCompiler(CompilerBase):
    """numba's compiler with an `_InnerLibrary`."""

    def define_pipelines(self) -> list[Any]:
        """The passes of numba, with the library into which they write."""
        context, name = self.state.targetctx, self.state.func_id.func_qualname
        self.state.library = _InnerLibrary(context.codegen(), name)
        return [DefaultPassBuilder.define_nopython_pipeline(self.state)]


class _InnerResults(CompileResultCacheImpl):
    """numba's way to store a compiled function, for functions with an `_InnerLibrary`."""

    def rebuild(self, target_context: Any, payload: Any) -> Any:
        """The compiled function of which numba has stored the payload."""
        (name, _, bitcode), fndesc, environment, signature, *_ = payload
        library = _InnerLibrary(target_context.codegen(), name)
        library._final_module = parse_bitcode(bitcode)
        library._finalize_final_module()
        return compile_result(
            typing_context=target_context.typing_context,
            target_context=target_context,
            library=library,
            fndesc=fndesc,
            environment=environment,
            signature=signature,
            objectmode=False,
            lifted=(),
            reload_init=(),
            entry_point=target_context.get_executable(library, fndesc, environment),
        )


class _InnerCache(_Cache):
    _impl_class = _InnerResults  # type: ignore[assignment]


def _foreign_sources(kind: Any) -> Any:
    """Names and sources of modules outside hpcrub that define classes in a type, or in a tuple."""
    if isinstance(kind, tuple):
        return set().union(*map(_foreign_sources, kind))
    if not isinstance(kind, types.BaseNamedTuple):
        return set()
    home = kind.instance_class.__module__  # type: ignore[attr-defined]
    others = _foreign_sources(tuple(kind.types))  # type: ignore[attr-defined]
    if home.startswith("hpcrub."):
        return others
    try:
        return {f"{home}\n{inspect.getsource(sys.modules[home])}", *others}
    except (OSError, TypeError):  # a notebook has no source: compile anew
        return {os.urandom(8).hex()}


def compiled(function: Callable | None = None, *, inline: bool = False, inner: bool = False) -> Any:
    """``numba.njit`` with the project's options: NumPy division rules, no fast-math, cached.

    function: function to compile; without it a decorator is returned.
    inline: whether the code is copied into every compiled caller.
    inner: whether only compiled code calls the function, and the function makes no arrays. It then
        has no wrapper for Python, which takes as long to compile as the function, and does not
        count references to its arguments, which costs more than the work in a call of every step.
    Returns a dispatcher, whose ``py_func`` is the function in plain Python, or the decorator.
    """

    def decorate(f: Any) -> Any:
        if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
            return f
        njit: Any = numba.njit  # its types lack options that it has
        dispatcher = njit(
            f,
            error_model="numpy",
            nogil=True,
            forceinline=inline,
            _nrt=not inner,
            no_cfunc_wrapper=True,
            no_cpython_wrapper=inner,
            pipeline_class=_InnerCompiler if inner else None,
        )
        if numba.config.CACHE_DIR:  # type: ignore[attr-defined]
            dispatcher._cache = (_InnerCache if inner else _Cache)(f)
        dispatcher.get_call_template = _without_literals(dispatcher.get_call_template)
        return dispatcher

    return decorate if function is None else decorate(function)


def _without_literals(template_of: Any) -> Any:
    """``template_of`` of a dispatcher that takes integer arguments by type, never by value.

    For a variable that begins with 0, numba would compile the function called once for this 0 and
    once for all integers: each such argument doubles the code of the function and its callees.
    """
    return lambda args, kws: template_of(
        tuple(map(types.unliteral, args)), {k: types.unliteral(v) for k, v in kws.items()}
    )


@infer_getattr
class _StaticMethods(AttributeTemplate):
    """Makes ``law.forces`` the compiled static method of the law's class in compiled code, too.

    The type of a law, surface or observer then chooses the code when its caller is compiled.
    """

    key = types.BaseNamedTuple

    def generic_resolve(self, value: Any, attr: str) -> Any:  # type: ignore[override]
        """Numba type of a compiled method; None for other attributes, such as fields."""
        method = getattr(value.instance_class, attr, None)
        return types.Dispatcher(method) if isinstance(method, Dispatcher) else None


# more specific kinds than that of numba's own function, which knows fields alone
@lower_getattr_generic(Group)
@lower_getattr_generic(types.NamedTuple)
@lower_getattr_generic(types.NamedUniTuple)
def _read(context: Any, builder: Any, kind: Any, value: Any, name: str) -> Any:
    """Read an attribute of a named tuple: a field, or a method, which has no value at run time."""
    if name not in kind.fields:
        return context.get_dummy_value()
    read = borrowed_member if isinstance(kind, Group) else namedtuple_getattr
    return read(context, builder, kind, value, name)
