"""A waveguide's squint against the sum over its slots, and its slope in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.radar.array import squint_deg
from seamap_rt.settings import AntennaSettings

DESIGN = 10e9


def end_fed(**keys: float) -> AntennaSettings:
    return AntennaSettings(**{"feed": "end", "design_frequency_hz": DESIGN, **keys})  # type: ignore[arg-type]


@pytest.mark.parametrize("frequency", [8e9, 9.3e9, 9.9e9, 10.1e9, 10.5e9, 12e9])
def test_the_beam_is_where_all_slots_are_in_phase(frequency: float) -> None:
    # Slots at half the design's guide wavelength, every other one reversed, the wave running away from the feed.
    settings = end_fed()
    cut_off = SPEED_OF_LIGHT / (2.0 * settings.guide_width_m)

    def guide_number(f: float) -> float:
        return 2.0 * np.pi / SPEED_OF_LIGHT * np.sqrt(f**2 - cut_off**2)

    slot = np.arange(60)
    place = slot * np.pi / guide_number(DESIGN)
    excitation = (-1.0) ** slot * np.exp(-1j * guide_number(frequency) * place)
    angle = np.linspace(-25.0, 25.0, 20_001)
    towards = np.exp(2j * np.pi * frequency / SPEED_OF_LIGHT * np.sin(np.radians(angle))[:, None] * place)
    beam = angle[np.argmax(np.abs(towards @ excitation))]
    assert squint_deg(settings, frequency) == pytest.approx(beam, abs=0.002)  # the angles' spacing is 0.0025°


def test_slope_about_the_design_frequency() -> None:
    # d sin θ/d ln f = (fc/f)²/√(1 − (fc/f)²) + √(1 − (fc/f)²) = 1/√(1 − (fc/f)²) = λg/λ
    cut_off = SPEED_OF_LIGHT / (2.0 * 0.02286)
    per_percent = np.degrees(0.01 / np.sqrt(1.0 - (cut_off / DESIGN) ** 2))
    assert per_percent == pytest.approx(0.76, abs=0.005)
    step = 1e-4
    rise = squint_deg(end_fed(), DESIGN * (1.0 + step)) - squint_deg(end_fed(), DESIGN * (1.0 - step))
    # a central difference: its error is of order step², 1e-8
    assert rise / (2.0 * step) == pytest.approx(100.0 * per_percent, rel=1e-6)


def test_positive_is_away_from_the_feed_as_the_frequency_rises() -> None:
    assert squint_deg(end_fed(), 1.01 * DESIGN) > 0.7
    assert squint_deg(end_fed(), 0.99 * DESIGN) < -0.7


@pytest.mark.parametrize("frequency", [8e9, 10e9, 12e9])
def test_none_at_the_design_frequency_nor_when_fed_in_the_middle(frequency: float) -> None:
    assert squint_deg(end_fed(design_frequency_hz=frequency), frequency) == pytest.approx(0.0, abs=1e-13)
    assert squint_deg(AntennaSettings(feed="end"), frequency) == pytest.approx(0.0, abs=1e-13)
    assert squint_deg(AntennaSettings(feed="centre", design_frequency_hz=9e9), frequency) == 0.0


@pytest.mark.parametrize(
    ("keys", "frequency", "line"),
    [
        ({}, 6.5e9, r"^radar\.frequency_hz = 6\.5e\+09: must be above the waveguide's cut-off, 6\.557e\+09 Hz; .*$"),
        (
            {"guide_width_m": 0.0149},
            10e9,
            r"^radar\.frequency_hz = 1e\+10: must be above .* radar\.antenna\.guide_width_m = 0\.0149$",
        ),
        ({"design_frequency_hz": 6e9}, 10e9, r"^radar\.antenna\.design_frequency_hz = 6e\+09: must be above .*$"),
        (
            {"design_frequency_hz": 20e9},
            7e9,
            r"^radar\.antenna\.design_frequency_hz = 2e\+10: must be nearer .* no beam .*$",
        ),
    ],
)
def test_refusals_in_one_line(keys: dict[str, float], frequency: float, line: str) -> None:
    with pytest.raises(ValueError, match=line):
        squint_deg(end_fed(**keys), frequency)
