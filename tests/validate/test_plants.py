"""The report fails loudly: an error planted in a formula turns exactly the cases red that rest on it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from seamap_rt import scattering
from seamap_rt.conventions import from_db
from seamap_rt.interferometry import poses
from seamap_rt.sea import spectra
from validation import analytic
from validation.analytic import phase
from validation.report import validate

FAST = (
    "dispersion_table",
    "doppler_of_what_moves",
    "lee_table",
    "nrl_sea_clutter",
    "shadow_tables",
    "sinusoid",
    "slopes_of_the_sea",
    "spectra_tables",
    "tilted_plane",
    "wavespectra_library",
)
JUDGED = ("doppler_of_what_moves", "sinusoid", "tilted_plane")  # by the retrieval's geometry


def red(folder: Path, *names: str) -> set[str]:
    result = validate(folder / "out", only=names, overwrite=True)
    assert len(result.done) == len(names)
    return {done.case.name for done in result.done if done.passed is False}


def test_without_a_plant_all_are_green(tmp_path: Path) -> None:
    assert red(tmp_path, *FAST) == set()


def test_a_per_cent_of_pierson_moskowitz(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    right = spectra.pierson_moskowitz
    monkeypatch.setattr(spectra, "pierson_moskowitz", lambda *args, **keys: 1.01 * right(*args, **keys))
    assert red(tmp_path, *FAST) == {"spectra_tables", "wavespectra_library"}


def test_a_baseline_that_is_two_per_cent_too_long(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    located = poses.located
    # ΔR/B is all that the inversion knows of the baseline, to first order.
    monkeypatch.setattr(poses, "located", lambda gate, difference, fan: located(gate, np.divide(difference, 1.02), fan))
    assert red(tmp_path, *JUDGED, "lee_table", "spectra_tables") == set(JUDGED)


def test_a_wrong_spread_of_phases(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    right = phase.phase_std_lee94
    monkeypatch.setattr(analytic, "phase_std_lee94", lambda coherence, looks: 1.05 * right(coherence, looks))
    names = "lee_table", "lee_phase_spread", "shadow_tables", "spectra_tables"
    assert red(tmp_path, *names) == {"lee_table", "lee_phase_spread"}


def test_a_digit_of_the_clutter_model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    right = scattering.nrcs_gregers_hansen12

    def swapped(grazing_deg: Any, sea_state: Any, frequency_hz: Any, polarization: str) -> Any:
        """25.56 in HH, where the report has 25.65."""
        found = right(grazing_deg, sea_state, frequency_hz, polarization)
        power = 1.0 / (2.0 + 0.085 * np.asarray(grazing_deg) + 0.033 * np.asarray(sea_state))
        lack_db = 0.09 * (np.asarray(sea_state) + 1.0) ** power if polarization == "HH" else 0.0
        return found * from_db(-lack_db)

    monkeypatch.setattr(scattering, "nrcs_gregers_hansen12", swapped)
    assert red(tmp_path, "nrl_sea_clutter", "git_sea_clutter", "sea_water") == {"nrl_sea_clutter"}
