"""Eight numbers at a time, as a processor's vector registers hold them, for numba's compiled loops.

Short sums of short rows are what compilers seldom put into vector registers by themselves. Here it is written out: a
variable of a compiled function can hold `LANES` numbers of single or double precision, or twice as many, and the
functions below act on all of them at once. Where a processor's registers are shorter, LLVM splits them. Each lane's
bits are the same in either width. Python itself can call nothing here.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, models, register_model

LANES = 8
_NUMBERS = {types.float32: ir.FloatType(), types.float64: ir.DoubleType()}
_INDEX = ir.IntType(32)
_FUSED = ("contract",)  # a product and its sum may be rounded once
_compiled_inline: Any = intrinsic  # compiled code calls it without the first argument, which is numba's own


class _Lanes(types.Type):
    """Numba's type of such a variable; number: the type of what each lane holds."""

    def __init__(self, number: Any, width: int = LANES) -> None:
        self.number, self.width = number, width
        super().__init__(f"Lanes({number}, {width})")

    @property
    def vector(self) -> Any:
        """LLVM's type of it."""
        return ir.VectorType(_NUMBERS[self.number], self.width)


@register_model(_Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, kind.vector)


@_compiled_inline
def zeros(context):
    """All lanes 0, of single precision."""
    made = _Lanes(types.float32)
    return made(), lambda *_: ir.Constant(made.vector, None)


@_compiled_inline
def zeros_of_two(context):
    """Twice LANES, all 0, of single precision."""
    made = _Lanes(types.float32, 2 * LANES)
    return made(), lambda *_: ir.Constant(made.vector, None)


@_compiled_inline
def spread(context, number):
    """All lanes one number."""

    def code(context, builder, signature, values):
        return _spread(builder, _Lanes(number), values[0])

    return _Lanes(number)(number), code


@_compiled_inline
def packed(context, numbers):
    """LANES numbers of double precision, a tuple of them, one a lane."""

    made = _Lanes(types.float64)

    def code(context, builder, signature, values):
        lanes = ir.Constant(made.vector, ir.Undefined)
        for n in range(LANES):
            lanes = builder.insert_element(lanes, builder.extract_value(values[0], n), ir.Constant(_INDEX, n))
        return lanes

    if numbers != types.UniTuple(types.float64, LANES):
        raise TypeError(f"numbers = {numbers}: must be {LANES} of float64, one a lane")
    return made(numbers), code


@_compiled_inline
def load(context, array, start):
    """The LANES numbers of a contiguous array from flat index `start` on, unchecked."""

    def code(context, builder, signature, values):
        return _load(context, builder, signature, signature.args[0], values)

    return _Lanes(_contiguous(array).dtype)(array, types.intp), code


@_compiled_inline
def load_as(context, like, array, start):
    """As `load`, as many as `like` has."""

    def code(context, builder, signature, values):
        return _load(context, builder, signature, signature.args[1], values[1:])

    return _Lanes(_contiguous(array).dtype, like.width)(like, array, types.intp), code


@_compiled_inline
def store(context, array, start, lanes):
    """Write them back to there, unchecked."""

    def code(context, builder, signature, values):
        kind, _, made = signature.args
        address = _address(context, builder, kind, made, *values[:2])
        builder.store(values[2], address, align=kind.dtype.bitwidth // 8)
        return context.get_dummy_value()

    return types.void(_contiguous(array), types.intp, lanes), code


@_compiled_inline
def prefetch(context, array, start):
    """Begin to bring near what lies at flat index `start`, to be loaded soon. Changes nothing, whatever the index."""

    def code(context, builder, signature, values):
        byte = ir.IntType(8).as_pointer()
        kind = signature.args[0]
        address = builder.bitcast(_address(context, builder, kind, _Lanes(kind.dtype), *values), byte)
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
        factors = _spread(builder, lanes, values[1])
        return builder.fadd(values[0], builder.fmul(factors, values[2], flags=_FUSED), flags=_FUSED)

    return lanes(lanes, lanes.number, lanes), code


@_compiled_inline
def add_product(context, total, first, second):
    """total + first · second, lane by lane."""

    def code(context, builder, signature, values):
        return builder.fadd(values[0], builder.fmul(*values[1:], flags=_FUSED), flags=_FUSED)

    return total(total, first, second), code


@_compiled_inline
def doubled(context, lanes):
    """The same numbers in double precision."""

    made = _Lanes(types.float64, lanes.width)

    def code(context, builder, signature, values):
        return builder.fpext(values[0], made.vector)

    return made(lanes), code


@_compiled_inline
def swapped(context, lanes):
    """Each even lane in place of the odd one after it, and that one in its."""

    def code(context, builder, signature, values):
        numbers = [ir.Constant(_INDEX, n ^ 1) for n in range(lanes.width)]
        order = ir.Constant(ir.VectorType(_INDEX, lanes.width), numbers)
        return builder.shuffle_vector(values[0], values[0], order)

    return lanes(lanes), code


@_compiled_inline
def where_known(context, tested, lanes):
    """The lanes where what is tested is a number, 0 where it is NaN."""

    def code(context, builder, signature, values):
        known = builder.fcmp_ordered("ord", values[0], values[0])
        return builder.select(known, values[1], ir.Constant(lanes.vector, None))

    return lanes(tested, lanes), code


@_compiled_inline
def product(context, first, second):
    """Lane by lane."""

    def code(context, builder, signature, values):
        return builder.fmul(*values, flags=_FUSED)

    return first(first, first), code


@_compiled_inline
def less(context, first, second):
    """first − second, lane by lane."""

    def code(context, builder, signature, values):
        return builder.fsub(*values, flags=_FUSED)

    return first(first, first), code


@_compiled_inline
def plus(context, first, second):
    """first + second, lane by lane."""

    def code(context, builder, signature, values):
        return builder.fadd(*values, flags=_FUSED)

    return first(first, first), code


@_compiled_inline
def ratio(context, first, second):
    """first / second, lane by lane."""

    def code(context, builder, signature, values):
        return builder.fdiv(*values)

    return first(first, first), code


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

    return first.number(first, first), code


def _spread(builder: Any, made: Any, number: Any) -> Any:
    """The number in all lanes of that type."""
    undefined = ir.Constant(made.vector, ir.Undefined)
    first = builder.insert_element(undefined, number, ir.Constant(_INDEX, 0))
    return builder.shuffle_vector(first, undefined, ir.Constant(ir.VectorType(_INDEX, made.width), None))


def _load(context: Any, builder: Any, signature: Any, kind: Any, place: Any) -> Any:
    """What the signature returns, from an array of that type and a flat index."""
    address = _address(context, builder, kind, signature.return_type, *place)
    return builder.load(address, align=kind.dtype.bitwidth // 8)


def _contiguous(array: Any) -> Any:
    """The array's type, if its numbers lie one after the other."""
    if not (isinstance(array, types.Array) and array.layout == "C" and array.dtype in _NUMBERS):
        raise TypeError(f"array = {array}: must be a C-contiguous array of float32 or float64")
    return array


def _address(context: Any, builder: Any, kind: Any, made: Any, array: Any, start: Any) -> Any:
    """Where the array's lanes of type `made` from `start` on lie in memory."""
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [start]), made.vector.as_pointer())
