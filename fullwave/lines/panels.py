"""Weighted sums of rows, eight columns at a time: the loop in which method-of-lines runs spend most of their time.

    out[at + c] = base[at + c] + sum_j weight[first + j] rows[start + j stride + c],     c = 0..7

numba does not compile such a short inner loop to vector instructions (measured: with plain loops, marches take 2 to 4 times
longer). Therefore the loop is written here in LLVM instructions, with vectors of eight doubles that LLVM adapts to the machine.
All arrays are one-dimensional, contiguous float64; indices are not checked.
"""

from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

LANES = 8
"""Columns of a panel; the size of flat arrays that are summed panel by panel is a multiple of it."""

_VECTOR = ir.VectorType(ir.DoubleType(), LANES)
_LANE_NUMBERS = ir.VectorType(ir.IntType(32), LANES)
_SWAPPED = ir.Constant(_LANE_NUMBERS, [*range(LANES // 2, LANES), *range(LANES // 2)])
_FUSE = ("contract",)


def _address(context: Any, builder: Any, kind: Any, array: Any, index: Any) -> Any:
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), _VECTOR.as_pointer())


def _weighted_sum(context: Any, builder: Any, kinds: Any, arguments: Any) -> Any:
    """The loop over j; returns the vector of eight sums."""
    weight, first, count, rows, start, stride = arguments
    total = cgutils.alloca_once_value(builder, ir.Constant(_VECTOR, [0.0] * LANES))
    weights = context.make_array(kinds[0])(context, builder, weight).data
    with cgutils.for_range(builder, count) as loop:
        factor = builder.load(builder.gep(weights, [builder.add(first, loop.index)]))
        lane = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), factor, ir.Constant(ir.IntType(32), 0))
        broadcast = builder.shuffle_vector(lane, lane, ir.Constant(_LANE_NUMBERS, [0] * LANES))
        index = builder.add(start, builder.mul(loop.index, stride))
        row = builder.load(_address(context, builder, kinds[3], rows, index), align=8)
        product = builder.fmul(broadcast, row, flags=_FUSE)
        builder.store(builder.fadd(builder.load(total), product, flags=_FUSE), total)
    return builder.load(total)


def _signature(arrays_and_indices: Any) -> Any:
    kinds = [types.intp if isinstance(kind, types.Integer) else kind for kind in arrays_and_indices]
    return types.void(*kinds)


@intrinsic  # type: ignore[untyped-decorator]
def add_rows(
    typing: Any, weight: Any, first: Any, count: Any, rows: Any, start: Any, stride: Any, base: Any, out: Any, at: Any
) -> Any:
    """out[at:at + 8] = base[at:at + 8] + sum over j < count of weight[first + j] * rows[start + j * stride:][:8]."""

    def _generate(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        kinds = signature.args
        total = _weighted_sum(context, builder, kinds, arguments[:6])
        held = builder.load(_address(context, builder, kinds[6], arguments[6], arguments[8]), align=8)
        target = _address(context, builder, kinds[7], arguments[7], arguments[8])
        builder.store(builder.fadd(held, total, flags=_FUSE), target, align=8)
        return context.get_dummy_value()

    return _signature((weight, first, count, rows, start, stride, base, out, at)), _generate


@intrinsic  # type: ignore[untyped-decorator]
def differentiate_rows(
    typing: Any, weight: Any, first: Any, count: Any, rows: Any, start: Any, stride: Any, scale: Any, out: Any, at: Any
) -> Any:
    """out[at:at + 8] = scale[start:start + 8] * the same sum with exchanged halves (D w to the stress, D s to the velocity)."""

    def _generate(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        kinds = signature.args
        total = _weighted_sum(context, builder, kinds, arguments[:6])
        factors = builder.load(_address(context, builder, kinds[6], arguments[6], arguments[4]), align=8)
        swapped = builder.shuffle_vector(total, total, _SWAPPED)
        target = _address(context, builder, kinds[7], arguments[7], arguments[8])
        builder.store(builder.fmul(factors, swapped, flags=_FUSE), target, align=8)
        return context.get_dummy_value()

    return _signature((weight, first, count, rows, start, stride, scale, out, at)), _generate
