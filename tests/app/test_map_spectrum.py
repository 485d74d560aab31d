"""The spectrum that is shown of maps: a known wave keeps its variance, its frequency and its direction."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from seamap_rt.app.source import Results, Source
from seamap_rt.app.waves_view import MOST_TURNS, map_spectra

_AMPLITUDE_M, _LENGTH_M, _FROM_DEG, _MAST_M = 0.5, 45.0, 300.0, 6.0
_FREQUENCY_HZ = np.sqrt(9.81 * 2.0 * np.pi / _LENGTH_M) / (2.0 * np.pi)


def _maps(looks_deg: np.ndarray, turns: int, noise_m: float) -> xr.Dataset:
    """Polar maps of one long-crested wave in deep water, each look at its own time in a turn of one second."""
    slant = np.arange(20.0, 200.0, 3.0)
    ground = np.sqrt(slant**2 - _MAST_M**2)
    k, omega = 2.0 * np.pi / _LENGTH_M, 2.0 * np.pi * _FREQUENCY_HZ
    toward = np.radians(_FROM_DEG + 180.0)
    look = np.radians(looks_deg)[:, None]
    time = np.arange(turns)[:, None] + looks_deg / 360.0
    along = ground * (np.sin(look) * np.sin(toward) + np.cos(look) * np.cos(toward))
    phase = k * along - omega * time[:, :, None]
    noise = noise_m * np.random.default_rng(1).standard_normal(phase.shape)
    height = _AMPLITUDE_M * np.cos(phase) + noise
    # water at the crest runs with the wave: towards the radar (positive away) by the cosine between look and way
    radial = _AMPLITUDE_M * omega * np.cos(phase) * np.cos(look - toward)
    dims = ("turn", "azimuth", "range")
    values = {"height": height, "height_std": np.full(height.shape, max(noise_m, 1e-3)), "radial_velocity": radial}
    values |= {"ground_range": np.broadcast_to(ground, height.shape), "quality": np.zeros(height.shape, np.int16)}
    return xr.Dataset(
        {name: (dims, each) for name, each in values.items()} | {"time": (("turn", "azimuth"), time)},
        {"turn": np.arange(turns), "azimuth": looks_deg, "range": slant},
        {
            "depth_m": np.inf, "current_m_s": [0.0, 0.0], "estimator": "plain", "cell_range_m": 3.0,
            "cell_azimuth_deg": 2.0, "azimuth_beamwidth_deg": 1.8,
        },
    )  # fmt: skip


def _folder(folder: Path, looks_deg: np.ndarray, turns: int = 2, truth: bool = True) -> Source:
    folder.mkdir(exist_ok=True)
    ground = xr.Dataset(coords={"x": np.arange(3.0), "y": np.arange(3.0)})
    for name, noise in (("maps", 0.05), ("truth", 0.0)):
        if name == "maps" or truth:
            tree = xr.DataTree.from_dict({"/polar": _maps(looks_deg, turns, noise), "/ground": ground})
            tree.to_netcdf(folder / f"{name}.nc", engine="h5netcdf")
    return Source(Results(folder))


def test_a_wave_keeps_its_variance_its_frequency_and_its_direction(tmp_path: Path) -> None:
    """∫ S df = a²/2: within a tenth, by the modes across the wave that are taken for the floor, and the map's own
    cells, which are divided out by a law; the frequency within the width of a ring; the direction within a bin."""
    found = map_spectra(_folder(tmp_path, np.arange(0.0, 360.0, 2.0)), 1)
    assert (found.turns, found.why) == (2, "")
    for each in (found.retrieved, found.true):
        assert each is not None
        known = np.isfinite(each.density)
        variance = float(np.trapezoid(each.density[known], each.frequency[known]))
        assert variance == pytest.approx(0.5 * _AMPLITUDE_M**2, rel=0.1)
        assert each.frequency[np.nanargmax(each.density)] == pytest.approx(_FREQUENCY_HZ, abs=0.01)
        assert each.directional is not None
        row, column = np.unravel_index(np.argmax(each.directional), each.directional.shape)
        assert each.direction[column] == pytest.approx(_FROM_DEG, abs=7.6)  # half a bin
        assert each.bins[row] == pytest.approx(_FREQUENCY_HZ, abs=0.015)
        step = each.bins[1] - each.bins[0]
        assert float(each.directional.sum() * 15.0 * step) == pytest.approx(variance, rel=0.2)


def test_few_looks_tell_no_directions_and_say_so(tmp_path: Path) -> None:
    found = map_spectra(_folder(tmp_path, np.arange(270.0, 330.0, 2.0)), 1)
    assert found.retrieved is not None
    assert found.retrieved.directional is None
    assert "less than 80°" in found.why


def test_a_retrieval_has_no_true_spectrum_and_the_last_turns_are_averaged(tmp_path: Path) -> None:
    source = _folder(tmp_path, np.arange(0.0, 360.0, 4.0), turns=MOST_TURNS + 2, truth=False)
    found = map_spectra(source, MOST_TURNS + 1)
    assert found.true is None
    assert found.turns == MOST_TURNS
    assert map_spectra(source, 0).turns == 1
