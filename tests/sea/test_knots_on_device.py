"""Coefficients of the sea's splines that are made on the device: the host's, and no byte for a knot."""

from __future__ import annotations

import gc
from typing import Any

import numpy as np
import pytest
from small_seas import PARTS

from seamap_rt.compute import placement
from seamap_rt.compute.array_library import numpy_library
from seamap_rt.compute.device import moved
from seamap_rt.sea import moving_field, realize
from seamap_rt.sea.fields import Kind, Relaxed
from seamap_rt.sea.knots import Knot, Strip
from seamap_rt.sea.knots_on_device import WavesOnDevice
from seamap_rt.sea.moving_field import MovingField
from seamap_rt.sea.wave_trains import Quantity

QUANTITIES: tuple[Quantity, ...] = ("elevation", "rate", "slope_east", "flow_north", "shift_east", "shift_north")
KINDS: tuple[Kind, ...] = ("elevation", "potential", "shift", Relaxed(0.3))
HALF_DAY = 12.0 * 3600.0


def part_of(name: str) -> Any:
    (part,) = realize(PARTS[name], seed=1).trains
    return part


def waves_of(field: MovingField) -> WavesOnDevice:
    waves = field._ahead, field._behind, field.lattice.omega, field.shape, field.time_step
    return WavesOnDevice(numpy_library(), *waves)


def relative_rms(found: np.ndarray, right: np.ndarray) -> float:
    return float(np.sqrt(np.mean((found - right) ** 2) / np.mean(right**2)))


@pytest.mark.parametrize("name", ["plane", "shallow plane", "line"])
def test_coefficients_made_there_are_the_hosts(name: str) -> None:
    """By another FFT: each sum of n terms in float32 is off by some 6e-8 √log n of its rms, as is the host's."""
    field = part_of(name).field
    strips = [field._whole] if field.lattice.line else [field._whole, Strip(64, 128), Strip(128, field.shape[0] - 64)]
    numbers = (0, 1, int(HALF_DAY / field.time_step))
    wanted: list[Knot] = [(number, kind) for number in numbers for kind in KINDS]
    for strip in strips:
        made = waves_of(field).coefficients(wanted, field._per_elevation, strip, field._columns)
        for (number, kind), there in zip(wanted, made, strict=True):
            right = field._coefficients(kind, field._state_at(number), strip)
            assert relative_rms(np.array(there).reshape(right.shape), right) <= 1e-6
    assert strips[-1].first + strips[-1].count > field.shape[0] or field.lattice.line  # one goes over the grid's end


def test_a_knots_bits_are_the_same_whatever_is_made_with_it() -> None:
    field = part_of("plane").field
    waves, whole, strip = waves_of(field), field._whole, Strip(64, 128)
    wanted: list[Knot] = [(number, kind) for number in (3, 4) for kind in KINDS]
    together = waves.coefficients(wanted, field._per_elevation, whole, field._columns)
    for knot, there in zip(wanted, together, strict=True):
        rows = np.array(there).reshape(whole.count, -1)[64:192]
        (alone,) = waves.coefficients([knot], field._per_elevation, strip, field._columns)
        np.testing.assert_array_equal(np.array(alone).reshape(rows.shape), rows)


@pytest.mark.parametrize("name", ["plane", "line"])
def test_waves_go_up_once_and_coefficients_never(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    part = part_of(name)
    rng = np.random.default_rng(4)
    x, y, t = rng.uniform(-400.0, 400.0, 2000), rng.uniform(-400.0, 400.0, 2000), rng.uniform(0.0, 3.0, 2000)
    right = part.sample(x, y, t, QUANTITIES)
    monkeypatch.setattr(moving_field, "WORTH_THE_DEVICE", 0)
    monkeypatch.setenv(placement.SEA, "device")
    monkeypatch.setenv(placement.SEA_FFT, "device")
    placement.library_for_sea()  # tried before bytes are counted
    again = part_of(name)
    field = again.field
    moved.forget()
    found = again.sample(x, y, t, QUANTITIES)
    # Either side's coefficients err by 1.5e-7 of their field, evenly over all waves. A gradient enlarges that, of the
    # shift, whose own waves are long, by five: 1.1e-6; and the sums over coefficients are of float32 as well.
    assert max(map(relative_rms, found, right)) <= 1.5e-6
    quadrant = field.lattice.omega.size  # ω in float64, and the factors of shift and potential in complex64
    waves = 2 * field._ahead.nbytes + quadrant * (8 + 2 * 8)
    few = 2**12  # bytes: weights in time
    assert waves + 24 * x.size <= moved.up_bytes <= waves + 24 * x.size + few
    for later in (0.0, 60.0):  # knots that are there, and others
        moved.forget()
        again.sample(x, y, t + later, QUANTITIES)
        assert moved.up_bytes <= 24 * x.size + few
    assert not field._cache  # the host has made none
    assert sum(strip.count for strip, _ in field._cache_there.values()) * 4 * field._columns <= moving_field.CACHE_BYTES


def test_coefficients_outlive_what_made_them() -> None:
    """They lie in Dr.Jit's memory, not in the library's, which other arrays take as soon as it is let go."""
    field = part_of("plane").field
    waves, whole = waves_of(field), field._whole
    (there,) = waves.coefficients([(0, "shift")], field._per_elevation, whole, field._columns)
    right = np.array(there)
    del waves
    gc.collect()
    taken = [np.full(right.size, np.nan, dtype=np.float32) for _ in range(8)]
    np.testing.assert_array_equal(np.array(there), right)
    assert len(taken) == 8
