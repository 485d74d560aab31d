"""Complex Gaussian numbers by counting: each is a function of its key and its number, whatever else is drawn.

So a facet keeps its numbers when its neighbours fall into shadow, and those in no beam need not be drawn. Bits
come from SplitMix64 (Steele, Lea & Flood 2014), normals from them by Box & Muller (1958), with polynomials in place of
logarithm, sine and cosine, which a processor's lanes can take together. A power is at most 16.6 times the mean: one in
sixteen million would be more.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...compute.compiled import compiled

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_ONE = np.float32(1.0)
_LN_2, _ROOT_2, _TURN = (np.float32(value) for value in (np.log(2.0), np.sqrt(2.0), 2.0 * np.pi))
_FACTORIALS = np.cumprod(np.arange(1.0, 13.0))
# Of sin a / a and cos a in powers of −a²: within 6e-8 up to a quarter turn.
_S1, _S2, _S3, _S4, _S5 = (np.float32(1.0 / _FACTORIALS[n]) for n in (2, 4, 6, 8, 10))
_C1, _C2, _C3, _C4, _C5, _C6 = (np.float32(1.0 / _FACTORIALS[n]) for n in (1, 3, 5, 7, 9, 11))
_L1, _L2, _L3, _L4 = (np.float32(2.0 / n) for n in (1, 3, 5, 7))  # of ln x in (x − 1)/(x + 1)


@compiled
def key_of(key, number):
    """The key of one member of a stream."""
    state = key + _GOLDEN * (np.uint64(number) + np.uint64(1))
    state = (state ^ (state >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    state = (state ^ (state >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return state ^ (state >> np.uint64(31))


@compiled
def unit_phasor(turns):
    """Cosine and sine, in single precision, of an angle in turns within ±½."""
    half = np.rint(np.float32(2.0) * turns)
    angle = (turns - np.float32(0.5) * half) * _TURN
    sign = _ONE - np.float32(2.0) * np.abs(half)
    z = -angle * angle
    sine = angle * (_ONE + z * (_S1 + z * (_S2 + z * (_S3 + z * (_S4 + z * _S5)))))
    cosine = _ONE + z * (_C1 + z * (_C2 + z * (_C3 + z * (_C4 + z * (_C5 + z * _C6)))))
    return sign * cosine, sign * sine


@compiled
def count_bits(key, bits):
    """Fill bits (n,) of a key."""
    for n in range(bits.size):
        bits[n] = key_of(key, n)


@compiled
def normals(bits, real, imag):
    """Fill real and imag (n,) with the unit complex Gaussians of random bits."""
    for n in range(bits.size):
        high = np.int32(bits[n] >> np.uint64(41))
        uniform = np.float32(np.float32(high) + np.float32(0.5)) * np.float32(2.0**-23)
        # ln of a float: its exponent, and its mantissa about √2.
        pattern = np.float32(uniform).view(np.int32)
        exponent = np.float32((pattern >> np.int32(23)) - np.int32(127))
        mantissa = np.int32(np.int32(pattern & np.int32(0x7FFFFF)) | np.int32(0x3F800000)).view(np.float32)
        ratio = (mantissa - _ROOT_2) / (mantissa + _ROOT_2)
        z = ratio * ratio
        logarithm = (exponent + np.float32(0.5)) * _LN_2 + ratio * (_L1 + z * (_L2 + z * (_L3 + z * _L4)))
        radius = np.sqrt(max(-logarithm, np.float32(0.0)))
        cosine, sine = unit_phasor(np.float32(np.int32(np.uint32(bits[n]))) * np.float32(2.0**-32))
        real[n], imag[n] = radius * cosine, radius * sine


@compiled
def draw(key, bits, real, imag):
    """Fill real and imag (n,) with unit complex Gaussians of a key; bits: room for n uint64."""
    count_bits(key, bits)
    normals(bits, real, imag)


@compiled
def draw_all(key, count, modes):
    """Unit complex Gaussians (mode, member) of the members 0 … count − 1 of a stream."""
    out = np.empty((modes, count), np.complex64)
    bits, real, imag = np.empty(modes, np.uint64), np.empty(modes, np.float32), np.empty(modes, np.float32)
    for member in range(count):
        draw(key_of(key, member), bits, real, imag)
        for mode in range(modes):
            out[mode, member] = complex(real[mode], imag[mode])
    return out


def gaussians(key: np.uint64, count: int, modes: int) -> NDArray[np.complex64]:
    """(mode, member) unit complex Gaussians: the same for a member whatever `count` is."""
    return draw_all(key, count, modes)
