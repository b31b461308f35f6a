"""LLVM vector instructions that compiled code has for the functions of ``lanes.py``."""

import functools
import itertools
import operator
from collections.abc import Callable
from inspect import Parameter, signature
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.extending import models, register_model
from numba.core.typing.templates import infer_global, make_intrinsic_template

from hpcrub.contact import lanes
from hpcrub.contact.groups import Group, member

DOUBLE = ir.DoubleType()
INDEX = ir.IntType(64)
BYTE = ir.IntType(8)
ZERO = ir.Constant(INDEX, 0)


class LaneVector(types.Type):
    """Numba type of one vector of doubles, a double per lane."""

    element = DOUBLE

    def __init__(self, width: int) -> None:
        self.width = width
        super().__init__(name=f"{type(self).__name__}({width})")


class LaneMask(LaneVector):
    """Numba type of one truth value per lane."""

    element = ir.IntType(1)


@register_model(LaneVector)
@register_model(LaneMask)
class _Model(models.PrimitiveModel):
    def __init__(self, manager: Any, fe_type: Any) -> None:
        super().__init__(manager, fe_type, ir.VectorType(fe_type.element, fe_type.width))


def _compile_as(function: Any, typed: Any) -> None:
    """Make numba compile a function as the instruction that ``typed`` returns for its types."""
    context = Parameter("typing", Parameter.POSITIONAL_ONLY)
    parameters = [context, *signature(function).parameters.values()]
    typed.__signature__ = signature(function).replace(parameters=parameters)
    template = make_intrinsic_template(function, typed, function.__name__)
    infer_global(function, types.Function(template))


def _instruction(function: Callable, returns: Callable) -> Callable:
    """Decorator for a function that emits the code of ``function`` in compiled code.

    returns: function from the numba types of the arguments to the numba type of the result.
    """

    def decorate(emit: Any) -> Any:
        def typed(typing: Any, *kinds: Any) -> tuple[Any, Any]:
            known = [types.intp if isinstance(kind, types.Integer) else kind for kind in kinds]
            return returns(*kinds)(*known), emit

        _compile_as(function, typed)
        return emit

    return decorate


def _members(builder: Any, kind: Any, value: Any) -> Any:
    """Members of a tile, or a single value as a list."""
    return cgutils.unpack_tuple(builder, value) if isinstance(kind, types.BaseTuple) else [value]


def _tile(builder: Any, kind: Any, members: Any) -> Any:
    """The tile of some members, or the only one of them."""
    return cgutils.pack_array(builder, members) if isinstance(kind, types.BaseTuple) else members[0]


def _like(kind: Any, member: Any) -> Any:
    """Numba type of a tile of members as long as the tuple ``kind``, or of one of them."""
    return types.UniTuple(member, len(kind)) if isinstance(kind, types.BaseTuple) else member


def _lane_by_lane(function: Any, kind: Any, emit: Any) -> None:
    """Make numba compile ``function`` of vectors and numbers as ``emit(builder, *vectors)``.

    In place of vectors it takes tiles, of which it returns a tile.
    """

    def typed(typing: Any, *kinds: Any) -> Any:
        tiles = [k for k in kinds if isinstance(k, types.UniTuple)]
        members = [k.dtype if k in tiles else k for k in kinds]
        lanes = [k for k in members if isinstance(k, LaneVector)]
        if not lanes or any(k not in lanes and not isinstance(k, types.Number) for k in members):
            return None
        width, tile = lanes[0].width, tiles[0] if tiles else None

        def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            parts = [_members(builder, *part) for part in zip(sig.args, args, strict=True)]
            longest = max(map(len, parts))
            results = []
            for i in range(longest):
                row = [part[i % len(part)] for part in parts]
                vectors = [_broadcast(builder, a, width) if a.type == DOUBLE else a for a in row]
                results.append(emit(builder, *vectors))
            return _tile(builder, sig.return_type, results)

        taken = [k if m in lanes else types.float64 for k, m in zip(kinds, members, strict=True)]
        return _like(tile, kind(width))(*taken), code

    _compile_as(function, typed)


def _address(
    context: Any, builder: Any, fe_type: Any, array: Any, row: int, column: int, pointee: Any
) -> Any:
    """Pointer to array[row, column] of a matrix in either order, or to array[row]."""
    struct = context.make_array(fe_type)(context, builder, array)
    if fe_type.ndim == 1:
        offset = row
    elif fe_type.layout == "F":
        offset = builder.add(builder.mul(column, builder.extract_value(struct.shape, 0)), row)
    else:
        offset = builder.add(builder.mul(row, builder.extract_value(struct.shape, 1)), column)
    return builder.bitcast(builder.gep(struct.data, [offset]), pointee.as_pointer())


def _broadcast(builder: Any, scalar: Any, width: int) -> Any:
    empty = ir.Constant(ir.VectorType(DOUBLE, width), ir.Undefined)
    one = builder.insert_element(empty, scalar, ir.Constant(ir.IntType(32), 0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), width), None)
    return builder.shuffle_vector(one, one, zeros)


def _fma(builder: Any, a: Any, b: Any, c: Any) -> Any:
    # llvm.fmuladd, because llvm.fma is a library call on a machine without the instruction
    function = cgutils.get_or_insert_function(
        builder.module, ir.FunctionType(a.type, [a.type] * 3), f"llvm.fmuladd.v{a.type.count}f64"
    )
    return builder.call(function, [a, b, c])


def _larger(builder: Any, a: Any, b: Any) -> Any:
    return builder.select(builder.fcmp_ordered(">", a, b), a, b)


def _magnitude(builder: Any, a: Any) -> Any:
    return _larger(builder, a, builder.fsub(ir.Constant(a.type, None), a))


def _inverse(builder: Any, a: Any) -> Any:
    one = _broadcast(builder, ir.Constant(DOUBLE, 1.0), a.type.count)
    zero = ir.Constant(a.type, None)
    positive = builder.fcmp_ordered(">", a, zero)
    return builder.select(positive, builder.fdiv(one, a), zero)


def _length(builder: Any, a: Any, b: Any) -> Any:
    total = builder.fadd(builder.fmul(a, a), builder.fmul(b, b))
    root = cgutils.get_or_insert_function(
        builder.module, ir.FunctionType(a.type, [a.type]), f"llvm.sqrt.v{a.type.count}f64"
    )
    return builder.call(root, [total])


def _frozen(builder: Any, value: Any) -> Any:
    """Value of which LLVM knows nothing.

    Where a row becomes a choice between its old and new numbers, LLVM else stores the new ones with
    a mask, for which AMD's processors with AVX2 take some ten cycles.
    """
    frozen = ir.instructions.Instruction(builder.block, value.type, "freeze", [value])
    builder._insert(frozen)
    return frozen


def _select(builder: Any, mask: Any, a: Any, b: Any) -> Any:
    return builder.select(mask, _frozen(builder, a), _frozen(builder, b))


for _function, _kind, _emit in (
    (operator.add, LaneVector, ir.IRBuilder.fadd),
    (operator.sub, LaneVector, ir.IRBuilder.fsub),
    (operator.mul, LaneVector, ir.IRBuilder.fmul),
    (operator.lt, LaneMask, lambda builder, a, b: builder.fcmp_ordered("<", a, b)),
    (operator.gt, LaneMask, lambda builder, a, b: builder.fcmp_ordered(">", a, b)),
    (lanes.fma, LaneVector, _fma),
    (lanes.larger, LaneVector, lambda builder, a, b: _larger(builder, a, _frozen(builder, b))),
    (lanes.magnitude, LaneVector, _magnitude),
    (lanes.inverse, LaneVector, _inverse),
    (lanes.length, LaneVector, _length),
    (lanes.select, LaneVector, _select),
):
    _lane_by_lane(_function, _kind, _emit)


@_instruction(lanes.splat, lambda lanes, x: LaneVector(len(lanes)))
def _splat(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return _broadcast(builder, args[1], sig.return_type.width)


def _row(context: Any, builder: Any, fe_type: Any, array: Any, row: int, vector: Any) -> Any:
    """Pointer to a row of a lane array; the row is as long as the vector."""
    data = context.make_array(fe_type)(context, builder, array).data
    return builder.gep(builder.bitcast(data, vector.as_pointer()), [row])


def _load_row(context: Any, builder: Any, fe_type: Any, array: Any, row: int, width: int) -> Any:
    at = _row(context, builder, fe_type, array, row, ir.VectorType(DOUBLE, width))
    return builder.load(at, align=8)


def _store_row(context: Any, builder: Any, fe_type: Any, array: Any, row: int, vector: Any) -> None:
    builder.store(vector, _row(context, builder, fe_type, array, row, vector.type), align=8)


def _scalar_at(
    context: Any, builder: Any, fe_type: Any, array: Any, row: int, column: int, width: int
) -> Any:
    """Vector with array[row, column] in every lane."""
    at = _address(context, builder, fe_type, array, row, column, DOUBLE)
    return _broadcast(builder, builder.load(at, align=8), width)


def _load_any(context: Any, builder: Any, fe_type: Any, array: Any, row: int, width: int) -> Any:
    """Row of a lane array, or an entry of an array that lanes share in every lane."""
    if fe_type.ndim == 1:
        return _scalar_at(context, builder, fe_type, array, row, ZERO, width)
    return _load_row(context, builder, fe_type, array, row, width)


@_instruction(lanes.load, lambda lanes, array, rows: _like(rows, LaneVector(len(lanes))))
def _load(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    kind, width = sig.args[1], len(sig.args[0])
    rows = _members(builder, sig.args[2], args[2])
    loaded = [_load_any(context, builder, kind, args[1], row, width) for row in rows]
    return _tile(builder, sig.return_type, loaded)


@_instruction(lanes.store, lambda array, rows, vectors: types.none)
def _store(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    rows, vectors = (_members(builder, *part) for part in zip(sig.args[1:], args[1:], strict=True))
    for row, vector in zip(rows, vectors, strict=True):
        _store_row(context, builder, sig.args[0], args[0], row, vector)
    return context.get_dummy_value()


@_instruction(lanes.any_lane, lambda mask: types.boolean)
def _any_lane(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    bits = builder.bitcast(args[0], ir.IntType(sig.args[0].width))
    return builder.icmp_unsigned("!=", bits, ir.Constant(bits.type, 0))


@_instruction(lanes.tile_splat, lambda tile, vector: types.UniTuple(vector, len(tile)))
def _tile_splat(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return cgutils.pack_array(builder, [args[1]] * sig.return_type.count)


@_instruction(lanes.tile_add, lambda tile, matrix, row, columns, vector: tile)
def _tile_add(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    tile, matrix, row, columns, vector = args
    for i, column in enumerate(cgutils.unpack_tuple(builder, columns)):
        kind, width = sig.args[1], sig.args[4].width
        factor = _scalar_at(context, builder, kind, matrix, row, column, width)
        member = _fma(builder, factor, vector, builder.extract_value(tile, i))
        tile = builder.insert_value(tile, member, i)
    return tile


def _parts(builder: Any, vector: Any) -> list[Any]:
    """The registers of this machine that hold a vector."""
    width = min(lanes.MACHINE.vector, vector.type.count)
    firsts = range(0, vector.type.count, width)
    return [builder.shuffle_vector(vector, vector, _places(range(i, i + width))) for i in firsts]


def _whole(builder: Any, parts: Any) -> Any:
    """The vector that some registers hold."""
    while len(parts) > 1:
        together = _places(range(2 * parts[0].type.count))
        pairs = zip(parts[::2], parts[1::2], strict=True)
        parts = [builder.shuffle_vector(a, b, together) for a, b in pairs]
    return parts[0]


def _places(numbers: Any) -> Any:
    kind = ir.VectorType(ir.IntType(32), len(numbers))
    return ir.Constant(kind, [ir.Constant(kind.element, i) for i in numbers])


@_instruction(lanes.tile_relax, lambda coupling, n_rows, rows, penetration, x: x)
def _tile_relax(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    coupling, n_rows, rows, penetration, x = args
    rows, x = (cgutils.unpack_tuple(builder, tile) for tile in (rows, x))
    # byte offsets of rows and columns, which the processor adds: no address for each pair
    size = ir.Constant(INDEX, 8 * x[0].type.count)
    columns = [builder.mul(row, size) for row in rows]
    coupling, penetration = (
        builder.bitcast(context.make_array(kind)(context, builder, array).data, BYTE.as_pointer())
        for kind, array in ((sig.args[0], coupling), (sig.args[3], penetration))
    )
    begins = [builder.gep(coupling, [builder.mul(column, n_rows)]) for column in columns]
    parts = [list(part) for part in zip(*(_parts(builder, v) for v in x), strict=True)]
    order = [*itertools.product(range(len(parts)), range(len(x)))]
    if (len(x) + 1) * len(parts) < lanes.MACHINE.registers:
        # the registers hold all points: the sums of one part run while those of another wait
        order.sort(key=operator.itemgetter(1))
    zero = ir.Constant(parts[0][0].type, None)
    for part, a in order:
        place = ir.Constant(INDEX, 8 * zero.type.count * part)

        def load(begin: Any, column: int, place: Any = place) -> Any:
            at = builder.gep(builder.gep(begin, [column]), [place])
            return builder.load(builder.bitcast(at, zero.type.as_pointer()), align=8)

        depth = load(penetration, columns[a])
        for b in (*range(a + 1, len(x)), *range(a)):
            depth = _fma(builder, builder.fneg(load(begins[a], columns[b])), parts[part][b], depth)
        parts[part][a] = _larger(builder, depth, zero)
    return cgutils.pack_array(builder, [_whole(builder, v) for v in zip(*parts, strict=True)])


def _fields(builder: Any, kind: Group, group: Any) -> Any:
    """Types and values of the members of a group, by name."""
    values = [member(builder, kind, group, name) for name in kind.fields]
    return dict(zip(kind.fields, zip(kind.types, values, strict=True), strict=True))


@_instruction(
    lanes.tile_advance,
    lambda force, first, state, scheme, before, external, step, late: types.none,
)
def _tile_advance(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    tile, first, state, scheme, before, external, step, late = zip(sig.args, args, strict=True)
    has_late = late[0] != types.none
    added = cgutils.unpack_tuple(builder, late[1]) if has_late else ()
    arrays = _fields(builder, *state) | _fields(builder, *scheme)
    width = tile[0].dtype.width

    def load(name: str) -> Any:
        fe_type, array = arrays[name]
        return _load_any(context, builder, fe_type, array, k, width)

    # a mode is stored before the next is loaded, which keeps LLVM from filling all registers
    for i, force in enumerate(cgutils.unpack_tuple(builder, tile[1])):
        k = builder.add(first[1], ir.Constant(INDEX, i))
        gain = load("gain")
        kick = builder.fmul(force, gain)
        q, d = (builder.fadd(load(name), kick) for name in ("position", "increment"))
        if before[0] != types.none:
            _store_row(context, builder, *before, k, d)
        if step[0] != types.none:
            stiff = builder.fmul(gain, load("omega2"))
            d = builder.fsub(builder.fmul(load("decay"), d), builder.fmul(stiff, q))
            if external[0] != types.none:
                push = _scalar_at(context, builder, *external, step[1], k, width)
                d = builder.fadd(d, builder.fmul(push, gain))
            if has_late:
                d = builder.fadd(d, builder.fmul(added[i], gain))
            q = builder.fadd(q, d)
        for name, vector in (("increment", d), ("position", q)):
            fe_type, array = arrays[name]
            _store_row(context, builder, fe_type, array, k, vector)
    return context.get_dummy_value()


@_instruction(lanes.tile_largest, lambda tile: tile.dtype)
def _tile_largest(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    members = cgutils.unpack_tuple(builder, args[0])
    return functools.reduce(lambda largest, one: _larger(builder, one, largest), members)


@_instruction(lanes.consecutive, lambda tile, first: types.UniTuple(types.intp, len(tile)))
def _consecutive(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    count = sig.return_type.count
    members = [builder.add(args[1], ir.Constant(INDEX, i)) for i in range(count)]
    return cgutils.pack_array(builder, members, ty=INDEX)


@_instruction(lanes.indices, lambda tile, array, first: types.UniTuple(types.intp, len(tile)))
def _indices(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    struct = context.make_array(sig.args[1])(context, builder, args[1])
    count = sig.return_type.count
    at = [builder.add(args[2], ir.Constant(INDEX, i)) for i in range(count)]
    members = [builder.load(builder.gep(struct.data, [i])) for i in at]
    return cgutils.pack_array(builder, members, ty=INDEX)
