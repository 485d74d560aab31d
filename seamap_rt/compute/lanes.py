"""Some numbers at a time, as a processor's vector registers hold them, for numba's compiled loops.

A variable of a compiled function can hold so many numbers of single precision, and the functions below act on all of
them at once. Where a processor's registers are shorter, LLVM splits them. Python itself can call nothing here.

The sea's splines sum short rows many times over: of a warm turn of choppy_sea (0.91 s of the processor, on a Zen 4)
plain loops took 0.11 s more (12 %). All other kernels are plain.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, models, register_model

_INDEX = ir.IntType(32)
_FUSED = ("contract",)  # a product and its sum may be rounded once
# Compiled code calls it without the first argument, which is numba's own; a width must be a constant.
_compiled_inline: Any = intrinsic(prefer_literal=True)


class _Lanes(types.Type):
    """Numba's type of such a variable."""

    def __init__(self, width: int) -> None:
        self.width = width
        super().__init__(f"Lanes({width})")

    @property
    def vector(self) -> Any:
        """LLVM's type of it."""
        return ir.VectorType(ir.FloatType(), self.width)


@register_model(_Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, kind.vector)


@_compiled_inline
def zeros(context, width):
    """So many lanes, all 0."""
    made = _Lanes(_constant(width))
    return made(width), lambda *_: ir.Constant(made.vector, None)


@_compiled_inline
def load(context, array, start, width):
    """So many numbers of a contiguous array from flat index `start` on, unchecked."""
    made = _Lanes(_constant(width))

    def code(context, builder, signature, values):
        return builder.load(_address(context, builder, signature.args[0], made, *values[:2]), align=4)

    return made(_contiguous(array), types.intp, width), code


@_compiled_inline
def store(context, array, start, lanes):
    """Write them back to there, unchecked."""

    def code(context, builder, signature, values):
        builder.store(values[2], _address(context, builder, signature.args[0], lanes, *values[:2]), align=4)
        return context.get_dummy_value()

    return types.void(_contiguous(array), types.intp, lanes), code


@_compiled_inline
def prefetch(context, array, start):
    """Begin to bring near what lies at flat index `start`, to be loaded soon. Changes nothing, whatever the index."""

    def code(context, builder, signature, values):
        byte = ir.IntType(8).as_pointer()
        address = builder.bitcast(_address(context, builder, signature.args[0], _Lanes(1), *values), byte)
        kind = ir.FunctionType(ir.VoidType(), [byte, _INDEX, _INDEX, _INDEX])
        function = cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0")
        to_read, closest, data = (ir.Constant(_INDEX, value) for value in (0, 3, 1))
        builder.call(function, [address, to_read, closest, data])
        return context.get_dummy_value()

    return types.void(_contiguous(array), types.intp), code


@_compiled_inline
def add(context, total, factor, lanes):
    """total + factor · lanes, with one factor for all lanes."""

    def code(context, builder, signature, values):
        undefined = ir.Constant(lanes.vector, ir.Undefined)
        first = builder.insert_element(undefined, values[1], ir.Constant(_INDEX, 0))
        factors = builder.shuffle_vector(first, undefined, ir.Constant(ir.VectorType(_INDEX, lanes.width), None))
        return builder.fadd(values[0], builder.fmul(factors, values[2], flags=_FUSED), flags=_FUSED)

    return lanes(lanes, types.float32, lanes), code


@_compiled_inline
def dot(context, first, second):
    """The sum of the lanes' products, by halves."""

    def code(context, builder, signature, values):
        total, width = builder.fmul(*values), first.width
        while width > 1:
            width //= 2
            low, high = (
                ir.Constant(ir.VectorType(_INDEX, width), [ir.Constant(_INDEX, start + n) for n in range(width)])
                for start in (0, width)
            )
            total = builder.fadd(builder.shuffle_vector(total, total, low), builder.shuffle_vector(total, total, high))
        return builder.extract_element(total, ir.Constant(_INDEX, 0))

    return types.float32(first, first), code


def _constant(width: Any) -> int:
    """A width that the compiler knows."""
    if not isinstance(width, types.IntegerLiteral):
        raise TypeError(f"width = {width}: must be a constant")
    return width.literal_value


def _contiguous(array: Any) -> Any:
    """The array's type, if its numbers lie one after the other."""
    if not (isinstance(array, types.Array) and array.layout == "C" and array.dtype == types.float32):
        raise TypeError(f"array = {array}: must be a C-contiguous array of float32")
    return array


def _address(context: Any, builder: Any, kind: Any, made: Any, array: Any, start: Any) -> Any:
    """Where the array's lanes of type `made` from `start` on lie in memory."""
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [start]), made.vector.as_pointer())
