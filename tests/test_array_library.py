"""The library that works in the device's memory: which one it is, and whose turn it is to write and to read."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from seamap_rt.compute import array_library, placement
from seamap_rt.compute.array_library import ArrayLibrary, numpy_library
from seamap_rt.compute.backend import Backend, choose, doctor_lines
from seamap_rt.compute.device import device
from seamap_rt.errors import InputError, NoBackend


@pytest.fixture
def on_cuda(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The device passes for a graphics processor, without CuPy."""
    backend = Backend("cuda", None, None, "", "cuda_ad_mono_polarized")
    monkeypatch.setattr(array_library, "prepare", lambda: backend)
    monkeypatch.setattr(choose, "prepare", lambda: backend)
    monkeypatch.setattr(placement, "_is_graphics_processor", lambda: True)
    monkeypatch.setitem(sys.modules, "cupy", None)  # importing it raises ImportError
    array_library.array_library.cache_clear()
    yield
    array_library.array_library.cache_clear()


def stand_in(waited: list[str], **changes: Any) -> ModuleType:
    """A module with what is asked of CuPy, by NumPy, in the memory of this processor."""
    module = ModuleType("cupy")
    stream = SimpleNamespace(synchronize=lambda: waited.append("wait"))
    given = {
        "from_dlpack": lambda there: np.array(there, copy=False),
        "cuda": SimpleNamespace(get_current_stream=lambda: stream),
        **{name: getattr(np, name) for name in ("fft", "exp", "zeros", "complex64", "asarray")},
    }
    vars(module).update(given | changes)
    return module


def doctors_line() -> str:
    (line,) = [line for line in doctor_lines() if "sea's FFT" in line]
    return line


def test_what_is_lent_is_the_devices_own_memory() -> None:
    """Not a copy, and nothing of NumPy's that could go while a kernel reads it."""
    there = device().dr.empty(device().Float, 1000)
    with numpy_library().writing([there]) as (lent,):
        lent[...] = np.arange(1000.0)
        assert np.shares_memory(lent, np.array(there, copy=False))
    del lent
    twice = 2.0 * there
    del there
    np.testing.assert_array_equal(np.array(twice), 2.0 * np.arange(1000.0))


def test_each_waits_for_the_other(monkeypatch: pytest.MonkeyPatch) -> None:
    """Their streams do not: Dr.Jit ends before the library writes, the library before Dr.Jit goes on, also where it
    fails."""
    order: list[str] = []
    of = device()
    there = of.dr.empty(of.Float, 8)
    monkeypatch.setattr(of.dr, "sync_thread", lambda: order.append("Dr.Jit"))
    library = ArrayLibrary("", np, lambda _: order.append("lent"), lambda: order.append("library"))
    with library.writing([there]):
        order.append("written")
    assert order == ["Dr.Jit", "lent", "written", "library"]
    with pytest.raises(MemoryError), library.writing([there]):
        raise MemoryError
    assert order[4:] == ["Dr.Jit", "lent", "library"]


def test_the_processor_makes_the_seas_coefficients_unless_the_device_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(placement, "_is_graphics_processor", lambda: False)
    assert placement.library_for_sea() is None
    monkeypatch.setenv(placement.SEA_FFT, "device")
    library = placement.library_for_sea()
    assert library is not None
    assert library.xp is np
    monkeypatch.setenv(placement.SEA_FFT, "gpu")
    with pytest.raises(InputError, match="SEAMAP_RT_SEA_FFT = gpu: must be processor or device"):
        placement.library_for_sea()


def test_without_cupy_a_graphics_processor_is_given_them(on_cuda: None, monkeypatch: pytest.MonkeyPatch) -> None:
    assert placement.library_for_sea() is None
    assert doctors_line().startswith("ok       sea's FFT       SciPy, on the processor; ")
    assert doctors_line().endswith("; `pip install 'seamap_rt[cuda]'` brings CuPy and its libraries")
    monkeypatch.setenv(placement.SEA_FFT, "device")
    assert doctors_line().startswith("MISSING  sea's FFT       SEAMAP_RT_SEA_FFT = device: ")
    with pytest.raises(NoBackend, match=r"cupy.*pip install 'seamap_rt\[cuda\]'.*; or leave SEAMAP_RT_SEA_FFT out"):
        placement.library_for_sea()


def test_with_cupy_it_makes_them(on_cuda: None, monkeypatch: pytest.MonkeyPatch) -> None:
    waited: list[str] = []
    monkeypatch.setitem(sys.modules, "cupy", stand_in(waited))
    library = placement.library_for_sea()
    assert library is not None
    assert library.name == "CuPy"
    assert waited == ["wait"]  # after it was tried
    assert doctors_line() == "ok       sea's FFT       CuPy, on the device"
    monkeypatch.setenv(placement.SEA_FFT, "processor")
    assert placement.library_for_sea() is None
    assert doctors_line() == "ok       sea's FFT       SciPy, on the processor"


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"from_dlpack": lambda there: np.array(there)}, r"CuPy makes .* of an impulse"),  # a copy
        ({"exp": lambda _: 1.0 / 0}, "division by zero;"),
    ],
)
def test_a_cupy_that_does_not_work_is_passed_over(
    changes: dict[str, Any], reason: str, on_cuda: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "cupy", stand_in([], **changes))
    assert placement.library_for_sea() is None
    monkeypatch.setenv(placement.SEA_FFT, "device")
    with pytest.raises(NoBackend, match=reason):
        placement.library_for_sea()
