"""LLVM vector instructions: compiled bodies of the functions of the same names in ``lanes.py``."""

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.extending import intrinsic, models, register_model

DOUBLE = ir.DoubleType()
INDEX = ir.IntType(64)

Emitter = tuple[Any, Callable]  # signature of an instruction, and the function that emits it


class LaneVector(types.Type):
    """Numba type of one vector of doubles, a double per lane."""

    def __init__(self, width):
        self.width = width
        super().__init__(name=f"LaneVector({width})")


class LaneMask(types.Type):
    """Numba type of one truth value per lane."""

    def __init__(self, width):
        self.width = width
        super().__init__(name=f"LaneMask({width})")


@register_model(LaneVector)
class _VectorModel(models.PrimitiveModel):
    def __init__(self, manager, fe_type):
        super().__init__(manager, fe_type, ir.VectorType(DOUBLE, fe_type.width))


@register_model(LaneMask)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, manager, fe_type):
        super().__init__(manager, fe_type, ir.VectorType(ir.IntType(1), fe_type.width))


def _vector(fe_type):
    return ir.VectorType(DOUBLE, fe_type.width)


def _address(context, builder, fe_type, array, row, column, pointee):
    """Pointer to array[row, column], whether rows or columns lie in one piece."""
    struct = context.make_array(fe_type)(context, builder, array)
    if fe_type.layout == "F":
        offset = builder.add(builder.mul(column, builder.extract_value(struct.shape, 0)), row)
    else:
        offset = builder.add(builder.mul(row, builder.extract_value(struct.shape, 1)), column)
    return builder.bitcast(builder.gep(struct.data, [offset]), pointee.as_pointer())


def _broadcast(builder, scalar, width):
    empty = ir.Constant(ir.VectorType(DOUBLE, width), ir.Undefined)
    one = builder.insert_element(empty, scalar, ir.Constant(ir.IntType(32), 0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), width), None)
    return builder.shuffle_vector(one, one, zeros)


def _fmuladd(builder, a, b, c):
    # llvm.fmuladd, not llvm.fma: on a machine without the instruction that one is a library call
    function = cgutils.get_or_insert_function(
        builder.module, ir.FunctionType(a.type, [a.type] * 3), f"llvm.fmuladd.v{a.type.count}f64"
    )
    return builder.call(function, [a, b, c])


def _scalar_at(context, builder, fe_type, array, row, column, i):
    """Load ``matrix[row, column + i]``."""
    column = builder.add(column, ir.Constant(INDEX, i))
    return builder.load(_address(context, builder, fe_type, array, row, column, DOUBLE), align=8)


def _load_row(context, builder, fe_type, array, row, width):
    pointee = ir.VectorType(DOUBLE, width)
    at = _address(context, builder, fe_type, array, row, ir.Constant(INDEX, 0), pointee)
    return builder.load(at, align=8)


def _store_row(context, builder, fe_type, array, row, vector):
    zero = ir.Constant(INDEX, 0)
    at = _address(context, builder, fe_type, array, row, zero, vector.type)
    builder.store(vector, at, align=8)


@intrinsic
def splat(typing: object, lanes: types.UniTuple, x: types.Type) -> Emitter:
    """Broadcast a number to all lanes."""
    out = LaneVector(len(lanes))

    def code(context, builder, signature, args):
        return _broadcast(builder, args[1], out.width)

    return out(lanes, types.float64), code


@intrinsic
def load(typing: object, lanes: types.UniTuple, array: types.Type, row: types.Type) -> Emitter:
    """Load a row as a vector."""
    out = LaneVector(len(lanes))

    def code(context, builder, signature, args):
        return _load_row(context, builder, array, args[1], args[2], out.width)

    return out(lanes, array, types.intp), code


@intrinsic
def store(typing: object, array: types.Type, row: types.Type, vector: LaneVector) -> Emitter:
    """Store a vector as a row."""

    def code(context, builder, signature, args):
        _store_row(context, builder, array, args[0], args[1], args[2])
        return context.get_dummy_value()

    return types.none(array, types.intp, vector), code


def _arithmetic(emit):
    """An intrinsic of lane vectors whose instruction is ``emit(builder, *args)``."""

    @intrinsic
    def binary(typing, a, b):
        return a(a, b), lambda context, builder, signature, args: emit(builder, *args)

    return binary


def _max(builder, a, b):
    return builder.select(builder.fcmp_ordered(">", a, b), a, b)


add = _arithmetic(lambda builder, a, b: builder.fadd(a, b))
sub = _arithmetic(lambda builder, a, b: builder.fsub(a, b))
mul = _arithmetic(lambda builder, a, b: builder.fmul(a, b))
larger = _arithmetic(_max)


@intrinsic
def fma(typing: object, a: LaneVector, b: LaneVector, c: LaneVector) -> Emitter:
    """Multiply and add, fused where the machine can."""
    return a(a, b, c), lambda context, builder, signature, args: _fmuladd(builder, *args)


@intrinsic
def positive_part(typing: object, a: LaneVector) -> Emitter:
    """Larger of a vector and 0."""

    def code(context, builder, signature, args):
        return _max(builder, args[0], ir.Constant(args[0].type, None))

    return a(a), code


@intrinsic
def inverse(typing: object, a: LaneVector) -> Emitter:
    """One over a vector, 0 where it is not positive."""

    def code(context, builder, signature, args):
        one = _broadcast(builder, ir.Constant(DOUBLE, 1.0), a.width)
        zero = ir.Constant(args[0].type, None)
        positive = builder.fcmp_ordered(">", args[0], zero)
        return builder.select(positive, builder.fdiv(one, args[0]), zero)

    return a(a), code


@intrinsic
def length(typing: object, a: LaneVector, b: LaneVector) -> Emitter:
    """Root of the sum of two squares."""

    def code(context, builder, signature, args):
        kind = args[0].type
        total = builder.fadd(builder.fmul(args[0], args[0]), builder.fmul(args[1], args[1]))
        root = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(kind, [kind]), f"llvm.sqrt.v{a.width}f64"
        )
        return builder.call(root, [total])

    return a(a, b), code


@intrinsic
def below(typing: object, a: LaneVector, b: LaneVector) -> Emitter:
    """Ordered comparison of two vectors."""

    def code(context, builder, signature, args):
        return builder.fcmp_ordered("<", *args)

    return LaneMask(a.width)(a, b), code


@intrinsic
def select(typing: object, mask: LaneMask, a: LaneVector, b: LaneVector) -> Emitter:
    """Blend of two vectors by a mask."""
    return a(mask, a, b), lambda context, builder, signature, args: builder.select(*args)


@intrinsic
def any_lane(typing: object, mask: LaneMask) -> Emitter:
    """Whether any bit of a mask is set."""

    def code(context, builder, signature, args):
        bits = builder.bitcast(args[0], ir.IntType(mask.width))
        return builder.icmp_unsigned("!=", bits, ir.Constant(bits.type, 0))

    return types.boolean(mask), code


@intrinsic
def tile_splat(typing: object, tile: types.UniTuple, vector: LaneVector) -> Emitter:
    """Tuple of the same vector."""
    out = types.UniTuple(vector, len(tile))

    def code(context, builder, signature, args):
        return cgutils.pack_array(builder, [args[1]] * out.count)

    return out(tile, vector), code


@intrinsic
def tile_gather(
    typing: object, lanes: types.UniTuple, array: types.Type, rows: types.UniTuple
) -> Emitter:
    """Load the rows of a tuple of numbers."""
    out = types.UniTuple(LaneVector(len(lanes)), len(rows))

    def code(context, builder, signature, args):
        members = [
            _load_row(context, builder, array, args[1], row, len(lanes))
            for row in cgutils.unpack_tuple(builder, args[2])
        ]
        return cgutils.pack_array(builder, members, ty=_vector(out.dtype))

    return out(lanes, array, rows), code


@intrinsic
def tile_store(typing: object, array: types.Type, row: types.Type, tile: types.UniTuple) -> Emitter:
    """Store consecutive rows."""

    def code(context, builder, signature, args):
        for i, member in enumerate(cgutils.unpack_tuple(builder, args[2])):
            row_i = builder.add(args[1], ir.Constant(INDEX, i))
            _store_row(context, builder, array, args[0], row_i, member)
        return context.get_dummy_value()

    return types.none(array, types.intp, tile), code


def _add_columns(context, builder, matrix, args, columns, width):
    value = args[0]
    for i, (column, offset) in enumerate(columns):
        scalar = _scalar_at(context, builder, matrix, args[1], args[2], column, offset)
        factor = _broadcast(builder, scalar, width)
        member = _fmuladd(builder, factor, args[4], builder.extract_value(args[0], i))
        value = builder.insert_value(value, member, i)
    return value


@intrinsic
def tile_add(
    typing: object,
    tile: types.UniTuple,
    matrix: types.Type,
    row: types.Type,
    column: types.Type,
    vector: LaneVector,
) -> Emitter:
    """Multiply-add with consecutive numbers of a row of a matrix."""

    def code(context, builder, signature, args):
        columns = [(args[3], i) for i in range(len(tile))]
        return _add_columns(context, builder, matrix, args, columns, vector.width)

    return tile(tile, matrix, types.intp, types.intp, vector), code


@intrinsic
def tile_add_at(
    typing: object,
    tile: types.UniTuple,
    matrix: types.Type,
    row: types.Type,
    columns: types.UniTuple,
    vector: LaneVector,
) -> Emitter:
    """Multiply-add with chosen numbers of a row of a matrix."""

    def code(context, builder, signature, args):
        chosen = [(column, 0) for column in cgutils.unpack_tuple(builder, args[3])]
        return _add_columns(context, builder, matrix, args, chosen, vector.width)

    return tile(tile, matrix, types.intp, columns, vector), code


@intrinsic
def tile_dot(
    typing: object,
    matrix: types.Type,
    row: types.Type,
    columns: types.UniTuple,
    tile: types.UniTuple,
    total: LaneVector,
) -> Emitter:
    """Multiply-adds into one vector, in order."""

    def code(context, builder, signature, args):
        result = args[4]
        members = cgutils.unpack_tuple(builder, args[3])
        for column, member in zip(cgutils.unpack_tuple(builder, args[2]), members, strict=True):
            scalar = _scalar_at(context, builder, matrix, args[0], args[1], column, 0)
            factor = _broadcast(builder, scalar, total.width)
            result = _fmuladd(builder, factor, member, result)
        return result

    return total(matrix, types.intp, columns, tile, total), code


@intrinsic
def tile_scatter(
    typing: object, array: types.Type, rows: types.UniTuple, tile: types.UniTuple
) -> Emitter:
    """Store the rows of a tuple of numbers."""

    def code(context, builder, signature, args):
        vectors = cgutils.unpack_tuple(builder, args[2])
        for row, member in zip(cgutils.unpack_tuple(builder, args[1]), vectors, strict=True):
            _store_row(context, builder, array, args[0], row, member)
        return context.get_dummy_value()

    return types.none(array, rows, tile), code


@intrinsic
def tile_relax(
    typing: object,
    coupling: types.Type,
    n_rows: types.Type,
    rows: types.UniTuple,
    depth: types.UniTuple,
    x: types.UniTuple,
    changing: LaneMask,
) -> Emitter:
    """Sweep of projected Gauss–Seidel, unrolled."""
    out = types.Tuple((depth, x, depth.dtype))

    def code(context, builder, signature, args):
        rows_, depth_, x_ = (cgutils.unpack_tuple(builder, args[i]) for i in (2, 3, 4))
        zero = ir.Constant(_vector(depth.dtype), None)
        change = zero
        for a, column in enumerate(rows_):
            new = builder.select(args[5], _max(builder, depth_[a], zero), x_[a])
            less = builder.fsub(x_[a], new)
            change = _max(builder, _max(builder, builder.fsub(zero, less), less), change)
            x_[a] = new
            for b, row in enumerate(rows_):
                if b != a:
                    at = builder.add(builder.mul(row, args[1]), column)
                    factor = _load_row(context, builder, coupling, args[0], at, depth.dtype.width)
                    depth_[b] = _fmuladd(builder, factor, less, depth_[b])
        tiles = [cgutils.pack_array(builder, members) for members in (depth_, x_)]
        return context.make_tuple(builder, out, [*tiles, change])

    return out(coupling, types.intp, rows, depth, x, changing), code


@intrinsic
def tile_largest(typing: object, tile: types.UniTuple) -> Emitter:
    """Largest member of a tile."""

    def code(context, builder, signature, args):
        result, *others = cgutils.unpack_tuple(builder, args[0])
        for member in others:
            result = _max(builder, member, result)
        return result

    return tile.dtype(tile), code


@intrinsic
def indices(typing: object, tile: types.UniTuple, array: types.Type, first: types.Type) -> Emitter:
    """Load consecutive integers as a tuple."""
    out = types.UniTuple(types.intp, len(tile))

    def code(context, builder, signature, args):
        struct = context.make_array(array)(context, builder, args[1])
        at = [builder.add(args[2], ir.Constant(INDEX, i)) for i in range(out.count)]
        members = [builder.load(builder.gep(struct.data, [i])) for i in at]
        return cgutils.pack_array(builder, members, ty=INDEX)

    return out(tile, array, types.intp), code
