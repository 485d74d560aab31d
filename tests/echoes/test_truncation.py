"""What the beam's sides and the pulse's flanks may leave out, and what that costs."""

from __future__ import annotations

import numpy as np
import pytest

from seamap_rt.echoes import slow_time
from seamap_rt.echoes.response import beam_truncation, tabulated, truncation_error_m, truncation_share
from seamap_rt.echoes.slow_time import widest
from seamap_rt.echoes.turn import turn_echoes, turn_voltages
from seamap_rt.mesh import polar_grid, surface_mesh
from seamap_rt.radar.array import antenna_array
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import BEAMS_BEYOND, pulses
from seamap_rt.radar.waveform import RangeResponse
from seamap_rt.settings import RadarSettings, TracingSettings
from seamap_rt.tracing.horizon import trace_horizon


def test_what_other_water_does_to_the_phase() -> None:
    """√(p/N) σ: two scatterers in each sample, the second with a share p of the power, at heights of their own.

    1500 trials of 40 samples: their rms is known to 2 %; terms of higher order in p are 3 % here.
    """
    rng, share, sigma, samples, per_metre = np.random.default_rng(1), 1e-3, 0.3, 40, 0.2
    shape = 1500, samples
    main, side = (rng.normal(size=(2, *shape)).T @ [1.0, 1j] for _ in range(2))
    of_main, of_side = (rng.normal(0.0, sigma, shape).T for _ in range(2))
    lower = main + np.sqrt(share) * side
    upper = main * np.exp(1j * per_metre * of_main) + np.sqrt(share) * side * np.exp(1j * per_metre * of_side)
    alone = np.angle(np.sum(main.conj() * main * np.exp(1j * per_metre * of_main), axis=0))
    turned = np.angle(np.sum(lower.conj() * upper, axis=0)) - alone
    assert np.sqrt(np.mean((turned / per_metre) ** 2)) == pytest.approx(np.sqrt(share / samples) * sigma, rel=0.08)


def test_the_share_follows_the_error_that_is_allowed() -> None:
    assert truncation_share(0.4, 0.02) == pytest.approx((0.002 / 0.4) ** 2)
    assert truncation_share(0.0, 0.02) == truncation_share(0.01, 0.02) == 1e-4  # −40 dB, however flat the sea


@pytest.mark.parametrize("pattern", ["gaussian", "slotted_waveguide"])
@pytest.mark.parametrize("share", [1e-4, 1e-5])
def test_the_beam_is_cut_where_that_share_lies_beyond(pattern: str, share: float) -> None:
    radar = RadarSettings.model_validate({"antenna": {"pattern": pattern}})
    beams, aerial = beam_truncation(radar, share), antenna_array(radar).first_antenna
    wide, never = antenna_array(radar).beam_deg / aerial.azimuth_beamwidth_deg, aerial.share_beyond(3.5)
    assert aerial.share_beyond(beams * wide) - never <= 1.02 * share  # by another quadrature, over ±90°
    assert beams == 1.0 or aerial.share_beyond((beams - 0.051) * wide) - never > 0.98 * share
    assert beam_truncation(radar, 0.0) == BEAMS_BEYOND


def test_the_error_that_is_stated_is_that_of_sides_and_flanks_together() -> None:
    """By quadratures of their own; a staring antenna hears its sides."""
    share, law = 1e-4, RangeResponse.of(RadarSettings())
    fine = np.linspace(0.0, law.support_m, 200001)
    power, kept = law(fine) ** 2, tabulated(RadarSettings(), share)
    flanks = power[fine >= (kept.response.shape[1] - 1) * kept.step].sum() / power.sum()
    turning, staring = (RadarSettings.model_validate({"scan": scan}) for scan in ("turning", "staring"))
    aerial = antenna_array(turning).first_antenna
    wide = antenna_array(turning).beam_deg / aerial.azimuth_beamwidth_deg
    aside = aerial.share_beyond(beam_truncation(turning, share) * wide) - aerial.share_beyond(3.5 * wide)
    for radar, left_out in ((turning, aside + flanks), (staring, flanks)):
        # An entry of the range table, 1 mm, holds 1 % of what lies beyond the cut.
        assert truncation_error_m(radar, 0.4, share) == pytest.approx(np.sqrt(left_out) * 0.4, rel=0.02)


def test_the_flanks_are_cut_where_that_share_lies_beyond() -> None:
    radar = RadarSettings()
    kept, law = tabulated(radar, 1e-4), RangeResponse.of(radar)
    fine = np.linspace(-law.support_m, law.support_m, 200001)
    power = law(fine) ** 2
    edge = (kept.response.shape[1] - 1) * kept.step
    assert power[np.abs(fine) > edge].sum() <= 1.01e-4 * power.sum()
    assert power[np.abs(fine) > edge - 0.01].sum() > 1e-4 * power.sum()
    assert kept.response[0, -1] == 0.0
    assert tabulated(radar).response.shape[1] > kept.response.shape[1]
    chirp = RadarSettings.model_validate({"waveform": "chirp", "pulse_width_s": 1e-7})
    np.testing.assert_array_equal(tabulated(chirp, 1e-4).response, tabulated(chirp).response)


def test_what_is_heard_stays_as_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    """Speckle that never changes has one number a facet, so a cut beam hears the same within, and nothing beyond."""
    radar = RadarSettings.model_validate({"sector_deg": [0.0, 40.0], "noise": False})
    grid = polar_grid(Installation(radar), TracingSettings(), 0)
    shape = (grid.sweep.size, grid.ground_range.size)
    facets = trace_horizon(surface_mesh(grid, np.zeros(shape), np.zeros((*shape, 3), np.float32)))
    rcs = np.zeros(facets.height.shape, np.float32)
    column, facet = grid.columns // 2, int(np.searchsorted(facets.distance, 100.0))
    rcs[column, facet] = 1.0
    fired, share = pulses(Installation(radar), 0), 1e-4
    # Every pulse summed: what is missed between nodes is another law's matter.
    monkeypatch.setattr(slow_time, "widest", lambda law, interval, share, _: widest(law, interval, share, 1))
    whole = turn_voltages(facets, rcs, Installation(radar), fired, 1, np.inf)
    cut = turn_echoes(facets, rcs, Installation(radar), fired, 1, np.inf, neglected=share).voltage
    aside = np.abs(fired.sweep - grid.column_sweep[column])
    beam, peak = antenna_array(radar).beam_deg, np.nanmax(np.abs(whole))
    far = aside > (beam_truncation(radar, share) + 1.0) * beam  # a window that ends at −40 dB rings a little further
    assert np.nanmax(np.abs(cut[far])) < 1e-3 * peak
    power = np.nansum(np.abs(whole) ** 2)
    assert np.nansum(np.abs(cut[far]) ** 2) < share * power
    assert np.nanmax(np.abs(whole[far])) > 2e-3 * peak
    own = int(np.argmax(np.nanmax(np.abs(whole), axis=(0, 1))))
    near = aside < 0.7 * beam
    np.testing.assert_allclose(cut[near][..., own], whole[near][..., own], rtol=0, atol=3e-3 * peak)
    left = cut[near][..., own] - whole[near][..., own]
    assert np.nansum(np.abs(left) ** 2) < share * power
