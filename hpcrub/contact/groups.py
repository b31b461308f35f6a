"""Groups of arrays in compiled code: named tuples that functions pass by reference.

numba passes a tuple by value. A bank has some hundred arrays of seven numbers each: every function
would take several hundred arguments, and every read of an attribute would copy them, which takes
half of the time to compile a kernel, and a fifth of that of a step to second order.
"""

from typing import Any

from numba.core import cgutils, types
from numba.core.datamodel.models import PrimitiveModel
from numba.core.extending import NativeValue, register_model, typeof_impl, unbox
from numba.core.imputils import impl_ret_borrowed


class Group(types.NamedTuple):
    """Numba type of a named tuple that compiled functions only read, passed by reference."""

    def __init__(self, kinds: Any, instance_class: type) -> None:
        super().__init__(kinds, instance_class)
        self.name = f"group {self.name}"  # its code is another one than that of the tuple

    @property
    def by_value(self) -> types.NamedTuple:
        """The type of numba for the same named tuple."""
        return types.NamedTuple(self.types, self.instance_class)


@register_model(Group)
class _Model(PrimitiveModel):
    def __init__(self, manager: Any, fe_type: Any) -> None:
        members = manager.lookup(fe_type.by_value).get_value_type()
        super().__init__(manager, fe_type, members.as_pointer())


@unbox(Group)
def _unbox(kind: Any, tuple_of_python: Any, c: Any) -> NativeValue:
    native = c.unbox(kind.by_value, tuple_of_python)
    place = cgutils.alloca_once_value(c.builder, native.value)

    def cleanup() -> None:
        if native.cleanup:
            native.cleanup()
        # numba lets go of the arrays of an argument by its type, which has none here
        c.context.nrt.decref(c.builder, kind.by_value, native.value)

    return NativeValue(place, native.is_error, cleanup)


def by_reference(kind: Any) -> Any:
    """The numba type of a named tuple as a `Group`, its members included; other types unchanged."""
    if not isinstance(kind, types.NamedTuple):
        return kind
    return Group([by_reference(member) for member in kind.types], kind.instance_class)


def passed_by_reference(own: type) -> type:
    """Class decorator: compiled functions take named tuples of this class by reference."""

    @typeof_impl.register(own)
    def _typeof(value: Any, context: Any) -> Any:
        return by_reference(typeof_impl.dispatch(tuple)(value, context))

    return own


def member(builder: Any, kind: Any, place: Any, name: str) -> Any:
    """Code that reads a member of a group; place: of the group in memory."""
    at = cgutils.gep_inbounds(builder, place, 0, kind.fields.index(name))
    loaded = builder.load(at)
    # nothing that a function stores changes a group, so that LLVM need not read it again
    loaded.set_metadata("invariant.load", builder.module.add_metadata([]))
    return loaded


def borrowed_member(context: Any, builder: Any, kind: Any, place: Any, name: str) -> Any:
    """Code that reads a member as an attribute, whose references numba counts."""
    of = kind.types[kind.fields.index(name)]
    return impl_ret_borrowed(context, builder, of, member(builder, kind, place, name))
