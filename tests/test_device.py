"""Arrays on the device: what goes there and comes back, and that it is counted."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
import xarray as xr

from seamap_rt.compute.complex_on_device import ComplexOnDevice
from seamap_rt.compute.device import device, moved


@pytest.mark.parametrize("kind", ["f4", "f8", "i4", "u4", "u8", "?"])
@pytest.mark.parametrize("size", [0, 1, 5, 1000])
def test_what_is_placed_is_a_copy(kind: str, size: int) -> None:
    """Not the host's own memory, which may change, or go before a kernel has run."""
    given = (np.arange(size) % 3).astype(kind)
    right, there = given.copy(), device().place(given)
    given[:] = 1
    np.testing.assert_array_equal(device().fetch(there, (size,)), right)
    assert device().dr.width(there) == size


def test_complex_numbers_there_are_an_array_and_come_here_once() -> None:
    rng = np.random.default_rng(1)
    values = (rng.normal(size=(4, 2, 3)) + 1j * rng.normal(size=(4, 2, 3))).astype(np.complex64)
    there = ComplexOnDevice.of(values)
    data = xr.Dataset({"voltage": (("pulse", "receiver", "range"), there)}, {"pulse": np.arange(4)})
    moved.forget()
    assert data["voltage"].data is there
    assert (there.shape, there.ndim, there.size, there.nbytes, len(there)) == ((4, 2, 3), 3, 24, 192, 4)
    assert moved.down_bytes == 0
    np.testing.assert_array_equal(data["voltage"].values, values)
    np.testing.assert_array_equal(data["voltage"].isel(pulse=slice(1, 3)).values, values[1:3])
    np.testing.assert_array_equal(abs(data["voltage"]).values, abs(values))
    np.testing.assert_array_equal(np.concatenate([there, there]), np.concatenate([values, values]))
    np.testing.assert_array_equal(2.0 * there, 2.0 * values)
    for each in (copy.deepcopy(data), pickle.loads(pickle.dumps(data))):
        assert isinstance(each["voltage"].data, np.ndarray)
        np.testing.assert_array_equal(each["voltage"].values, values)
    assert moved.down_bytes == values.nbytes
