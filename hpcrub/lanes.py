"""A SIMD register of a few simulations, for numba kernels.

Several angular speeds of one sample advance together, one per *lane*. A value of type ``Lanes`` is
one hardware vector that holds the same quantity of every lane, and a *tile* is a tuple of such
vectors that stays in registers. numba alone keeps neither in registers (a loop over lanes loads and
stores its accumulators at every pass), which costs a factor of three to five here.

Every function below has a plain-Python body, in which a lane vector is a NumPy row, and a compiled
one that emits LLVM vector instructions; so ``kernel.py_func`` runs unchanged in plain Python.

Lane arrays have shape (rows, width) and are C-contiguous; ``lanes`` is a tuple of ``width`` zeros
whose *length* tells the compiler the vector width, ``tile`` one whose length tells the tile size.
"""

import operator

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.extending import intrinsic, models, overload, register_model

DOUBLE = ir.DoubleType()
INDEX = ir.IntType(64)


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


def aligned_zeros(shape):
    """Zeros of ``shape`` on a cache-line boundary, so that no vector load straddles two lines."""
    n_bytes = int(np.prod(shape)) * 8
    raw = np.zeros(n_bytes + 64, dtype=np.uint8)
    start = -raw.ctypes.data % 64
    return raw[start : start + n_bytes].view(np.float64).reshape(shape)


# --- plain-Python bodies ---------------------------------------------------------------------


def splat(lanes, x):
    """The number ``x`` in every lane."""
    return np.full(len(lanes), x)


def load(lanes, array, row):
    """Row ``row`` of a lane array."""
    return array[row].copy()


def store(array, row, vector):
    """Write ``vector`` to row ``row`` of a lane array (modified)."""
    array[row] = vector


def fma(a, b, c):
    """a·b + c, fused where the machine can."""
    return a * b + c


def positive_part(a):
    """max(a, 0) of every lane; NaN becomes 0."""
    return np.where(a > 0.0, a, 0.0)


def larger(a, b):
    """The larger of a and b in every lane; b where a is NaN."""
    return np.where(a > b, a, b)


def below(a, b):
    """Mask of the lanes in which a < b; False where either is NaN."""
    return a < b


def select(mask, a, b):
    """a where the mask holds, b elsewhere."""
    return np.where(mask, a, b)


def any_lane(mask):
    """Whether the mask holds in any lane."""
    return bool(np.any(mask))


def tile_splat(tile, vector):
    """A tile whose members are all ``vector``."""
    return tuple(vector for _ in tile)


def tile_load(lanes, tile, array, row):
    """Rows ``row`` … of a lane array as a tile."""
    return tuple(array[row + i].copy() for i in range(len(tile)))


def tile_store(array, row, tile):
    """Write a tile to rows ``row`` … of a lane array (modified)."""
    for i, vector in enumerate(tile):
        array[row + i] = vector


def tile_add(tile, matrix, row, column, vector):
    """Each tile member plus ``matrix[row, column + i]`` times the vector."""
    return tuple(t + matrix[row, column + i] * vector for i, t in enumerate(tile))


def tile_dot(matrix, row, columns, tile, total):
    """total + Σ ``matrix[row, columns[i]]``·tile[i], added in order: a zero member changes no bit."""
    for column, t in zip(columns, tile):
        total = total + matrix[row, column] * t
    return total


def tile_gather(lanes, array, rows):
    """The rows of a lane array that the tuple ``rows`` names, as a tile."""
    return tuple(array[row].copy() for row in rows)


def tile_largest(tile):
    """The largest member of a tile, lane by lane."""
    result = tile[0]
    for t in tile[1:]:
        result = larger(t, result)
    return result


def indices(tile, array, first):
    """Members ``first`` … of an integer array as a tuple as long as ``tile``."""
    return tuple(int(array[first + i]) for i in range(len(tile)))


# --- compiled bodies -------------------------------------------------------------------------


def _vector(fe_type):
    return ir.VectorType(DOUBLE, fe_type.width)


def _is_lane_array(fe_type):
    return isinstance(fe_type, types.Array) and fe_type.ndim == 2 and fe_type.layout == "C"


def _address(context, builder, fe_type, array, row, column, pointee):
    """Pointer to array[row, column]; rows are as long as the array's second dimension."""
    struct = context.make_array(fe_type)(context, builder, array)
    n_columns = builder.extract_value(struct.shape, 1)
    offset = builder.add(builder.mul(row, n_columns), column)
    return builder.bitcast(builder.gep(struct.data, [offset]), pointee.as_pointer())


def _broadcast(builder, scalar, width):
    one = builder.insert_element(
        ir.Constant(ir.VectorType(DOUBLE, width), ir.Undefined),
        scalar,
        ir.Constant(ir.IntType(32), 0),
    )
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), width), None)
    return builder.shuffle_vector(one, one, zeros)


def _fmuladd(builder, a, b, c):
    # llvm.fmuladd, not llvm.fma: on a machine without the instruction that one is a library call
    function = cgutils.get_or_insert_function(
        builder.module, ir.FunctionType(a.type, [a.type] * 3), f"llvm.fmuladd.v{a.type.count}f64"
    )
    return builder.call(function, [a, b, c])


def _scalar_at(context, builder, fe_type, array, row, column, i):
    """matrix[row, column + i]"""
    column = builder.add(column, ir.Constant(INDEX, i))
    return builder.load(_address(context, builder, fe_type, array, row, column, DOUBLE), align=8)


@intrinsic
def _splat(typing, lanes, x):
    out = LaneVector(len(lanes))

    def code(context, builder, signature, args):
        return _broadcast(builder, args[1], out.width)

    return out(lanes, types.float64), code


@intrinsic
def _load(typing, lanes, array, row):
    out = LaneVector(len(lanes))

    def code(context, builder, signature, args):
        zero = ir.Constant(INDEX, 0)
        at = _address(context, builder, array, args[1], args[2], zero, _vector(out))
        return builder.load(at, align=8)

    return out(lanes, array, types.intp), code


@intrinsic
def _store(typing, array, row, vector):
    def code(context, builder, signature, args):
        zero = ir.Constant(INDEX, 0)
        at = _address(context, builder, array, args[0], args[1], zero, _vector(vector))
        builder.store(args[2], at, align=8)
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


_add = _arithmetic(lambda builder, a, b: builder.fadd(a, b))
_sub = _arithmetic(lambda builder, a, b: builder.fsub(a, b))
_mul = _arithmetic(lambda builder, a, b: builder.fmul(a, b))
_larger = _arithmetic(_max)


@intrinsic
def _fma(typing, a, b, c):
    return a(a, b, c), lambda context, builder, signature, args: _fmuladd(builder, *args)


@intrinsic
def _positive_part(typing, a):
    def code(context, builder, signature, args):
        return _max(builder, args[0], ir.Constant(args[0].type, None))

    return a(a), code


@intrinsic
def _below(typing, a, b):
    def code(context, builder, signature, args):
        return builder.fcmp_ordered("<", *args)

    return LaneMask(a.width)(a, b), code


@intrinsic
def _select(typing, mask, a, b):
    return a(mask, a, b), lambda context, builder, signature, args: builder.select(*args)


@intrinsic
def _any_lane(typing, mask):
    def code(context, builder, signature, args):
        bits = builder.bitcast(args[0], ir.IntType(mask.width))
        return builder.icmp_unsigned("!=", bits, ir.Constant(bits.type, 0))

    return types.boolean(mask), code


@intrinsic
def _tile_splat(typing, tile, vector):
    out = types.UniTuple(vector, len(tile))

    def code(context, builder, signature, args):
        return cgutils.pack_array(builder, [args[1]] * out.count)

    return out(tile, vector), code


def _load_row(context, builder, fe_type, array, row, width):
    pointee = ir.VectorType(DOUBLE, width)
    at = _address(context, builder, fe_type, array, row, ir.Constant(INDEX, 0), pointee)
    return builder.load(at, align=8)


@intrinsic
def _tile_load(typing, lanes, tile, array, row):
    out = types.UniTuple(LaneVector(len(lanes)), len(tile))

    def code(context, builder, signature, args):
        rows = [builder.add(args[3], ir.Constant(INDEX, i)) for i in range(out.count)]
        return cgutils.pack_array(
            builder, [_load_row(context, builder, array, args[2], row, len(lanes)) for row in rows]
        )

    return out(lanes, tile, array, types.intp), code


@intrinsic
def _tile_gather(typing, lanes, array, rows):
    out = types.UniTuple(LaneVector(len(lanes)), len(rows))

    def code(context, builder, signature, args):
        return cgutils.pack_array(
            builder,
            [
                _load_row(context, builder, array, args[1], row, len(lanes))
                for row in cgutils.unpack_tuple(builder, args[2])
            ],
            ty=_vector(out.dtype),
        )

    return out(lanes, array, rows), code


@intrinsic
def _tile_store(typing, array, row, tile):
    def code(context, builder, signature, args):
        zero = ir.Constant(INDEX, 0)
        for i in range(len(tile)):
            row_i = builder.add(args[1], ir.Constant(INDEX, i))
            at = _address(context, builder, array, args[0], row_i, zero, _vector(tile.dtype))
            builder.store(builder.extract_value(args[2], i), at, align=8)
        return context.get_dummy_value()

    return types.none(array, types.intp, tile), code


@intrinsic
def _tile_add(typing, tile, matrix, row, column, vector):
    def code(context, builder, signature, args):
        value = args[0]
        for i in range(len(tile)):
            scalar = _scalar_at(context, builder, matrix, args[1], args[2], args[3], i)
            factor = _broadcast(builder, scalar, vector.width)
            member = _fmuladd(builder, factor, args[4], builder.extract_value(args[0], i))
            value = builder.insert_value(value, member, i)
        return value

    return tile(tile, matrix, types.intp, types.intp, vector), code


@intrinsic
def _tile_dot(typing, matrix, row, columns, tile, total):
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
def _tile_largest(typing, tile):
    def code(context, builder, signature, args):
        result, *others = cgutils.unpack_tuple(builder, args[0])
        for member in others:
            result = _max(builder, member, result)
        return result

    return tile.dtype(tile), code


@intrinsic
def _indices(typing, tile, array, first):
    out = types.UniTuple(types.intp, len(tile))

    def code(context, builder, signature, args):
        struct = context.make_array(array)(context, builder, args[1])
        at = [builder.add(args[2], ir.Constant(INDEX, i)) for i in range(out.count)]
        members = [builder.load(builder.gep(struct.data, [i])) for i in at]
        return cgutils.pack_array(builder, members, ty=INDEX)

    return out(tile, array, types.intp), code


overload(splat)(lambda lanes, x: lambda lanes, x: _splat(lanes, x))
overload(load)(lambda lanes, array, row: lambda lanes, array, row: _load(lanes, array, row))
overload(store)(lambda array, row, vector: lambda array, row, vector: _store(array, row, vector))
overload(fma)(lambda a, b, c: lambda a, b, c: _fma(a, b, c))
overload(positive_part)(lambda a: lambda a: _positive_part(a))
overload(larger)(lambda a, b: lambda a, b: _larger(a, b))
overload(below)(lambda a, b: lambda a, b: _below(a, b))
overload(select)(lambda mask, a, b: lambda mask, a, b: _select(mask, a, b))
overload(any_lane)(lambda mask: lambda mask: _any_lane(mask))
overload(indices)(
    lambda tile, array, first: lambda tile, array, first: _indices(tile, array, first)
)
overload(tile_splat)(lambda tile, vector: lambda tile, vector: _tile_splat(tile, vector))
overload(tile_largest)(lambda tile: lambda tile: _tile_largest(tile))
overload(tile_gather)(
    lambda lanes, array, rows: lambda lanes, array, rows: _tile_gather(lanes, array, rows)
)
overload(tile_load)(
    lambda lanes, tile, array, row: (
        lambda lanes, tile, array, row: _tile_load(lanes, tile, array, row)
    )
)
overload(tile_store)(
    lambda array, row, tile: lambda array, row, tile: _tile_store(array, row, tile)
)
overload(tile_add)(
    lambda tile, matrix, row, column, vector: (
        lambda tile, matrix, row, column, vector: _tile_add(tile, matrix, row, column, vector)
    )
)
overload(tile_dot)(
    lambda matrix, row, columns, tile, total: lambda matrix, row, columns, tile, total: _tile_dot(
        matrix, row, columns, tile, total
    )
)


def _operator(function, compiled):
    @overload(function)
    def typed(a, b):
        if isinstance(a, LaneVector) and isinstance(b, LaneVector):
            return lambda a, b: compiled(a, b)
        return None


_operator(operator.add, _add)
_operator(operator.sub, _sub)
_operator(operator.mul, _mul)
