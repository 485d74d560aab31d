"""What seas drawn from many seeds have on average: heights, periods, directions, slopes, distributions, dispersion.

Waves on a periodic lattice are independent: |a|²/2 of each is exponential with mean v, so a sum Σ c |a|²/2 has variance
Σ c² v². Means over a whole patch are such sums, with a wave and the one that runs against it taken together: their
exact standard errors follow from the expected spectrum alone.
"""

from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import hilbert

from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.physics.dispersion import angular_frequency, wavenumber
from seamap_rt.sea import realize, spectral_system
from seamap_rt.settings import (
    ElfouhailyWaves,
    FileWaves,
    JonswapWaves,
    PiersonMoskowitzWaves,
    RandomWaves,
    SeaSettings,
    TmaWaves,
)

EXTENT, RESOLUTION, SIDE = 256.0, 4.0, 64
SPREADINGS = ("cos2s", "mitsuyasu", "hasselmann", "donelan_banner", "elfouhaily")
SWAN = str(Path(__file__).parents[1] / "io" / "spectra" / "swan.spc")


def jonswap(**changes):
    return JonswapWaves(**{"spectrum": "jonswap", "significant_wave_height_m": 1.4, "peak_period_s": 5.5, **changes})


def elfouhaily(**changes):
    return ElfouhailyWaves(**{"spectrum": "elfouhaily", "wind_speed_m_s": 7.0, **changes})


def sea_of(*waves, **changes):
    return SeaSettings(**{"resolution_m": RESOLUTION, "extent_m": EXTENT, "waves": waves, **changes})


WAVES: dict[str, RandomWaves] = {  # what else spreads them is held by the annuli of the plane
    "cos2s": jonswap(wave_from_deg=250.0),
    "hasselmann": jonswap(spreading="hasselmann", wave_from_deg=250.0),
    "elfouhaily sea": elfouhaily(wave_from_deg=250.0),
}
SEEDS = 20


@cache
def many_seas(name):
    return [realize(sea_of(WAVES[name]), seed) for seed in range(SEEDS)]


def whole_patch(sea, t, quantity="elevation"):
    """A quantity on the 64 × 64 points, rows north, that hold all waves of the patch: means over them are exact."""
    places = EXTENT * np.arange(SIDE) / SIDE
    return getattr(sea, quantity)(places[None, :], places[:, None], t)


def lattice(sea):
    """kx, ky, |k| and expected variance v of each wave, rows ky."""
    spectrum = sea.spectrum
    east, north = np.meshgrid(spectrum.kx, spectrum.ky)
    step = float(spectrum.kx[1] - spectrum.kx[0])
    return east, north, np.hypot(east, north), spectrum.variance_density.to_numpy() * step**2


def pairs_error(v, factor):
    """Standard error of the patch's mean of a square, c = `factor` for each wave: √ of Σ over pairs (c v + c v′)²."""
    weighted = factor * v
    return np.sqrt(0.5 * np.sum((weighted + weighted[::-1, ::-1]) ** 2))


# ------------------------------------------------------------------------------------------- heights and directions


@pytest.mark.parametrize("name", WAVES)
def test_moments_of_many_seas_lie_within_their_own_intervals(name):
    """Hs, Tm02, up- and cross-wind slopes, direction and spread, each from the surface over the ground."""
    toward = unit_from_azimuth(70.0)
    seas, seeds = many_seas(name), SEEDS
    squares, flux = [], []
    for sea in seas:
        elevation, rate, slopes = (whole_patch(sea, 3.7, name) for name in ("elevation", "elevation_rate", "slopes"))
        up = slopes @ np.array(toward)
        cross = slopes @ np.array([-toward[1], toward[0]])
        squares.append([np.mean(each**2) for each in (elevation, rate, up, cross)])
        flux.append([-np.mean(rate * up), -np.mean(rate * cross)])
    east, north, k, v = lattice(seas[0])
    along, across = toward[0] * east + toward[1] * north, toward[0] * north - toward[1] * east
    omega = angular_frequency(k, np.inf)
    for found, factor in zip(np.mean(squares, axis=0), (np.ones_like(k), omega**2, along**2, across**2), strict=True):
        error = pairs_error(v, factor) / np.sqrt(seeds)
        # Four standard errors, and what interpolation costs: 1e-3 of each amplitude at most.
        assert abs(found - np.sum(factor * v)) < 4.0 * error + 2e-3 * found
        assert error < 0.07 * np.sum(factor * v)
    # −⟨∂η/∂t ∇η⟩ = Σ ω k ½|a|²: which way the waves go, without beats of opposite waves.
    for found, factor in zip(np.mean(flux, axis=0), (omega * along, omega * across), strict=True):
        assert abs(found - np.sum(factor * v)) < 4.0 * np.sqrt(np.sum((factor * v) ** 2) / seeds) + 2e-3 * abs(found)
    # The same from the continuous spectrum to the same limit: heights and periods are those that were asked for.
    limit = np.pi / RESOLUTION
    log_k = np.linspace(np.log(1e-3), np.log(limit), 20_001)
    radial = spectral_system(WAVES[name], np.inf).radial(np.exp(log_k)) * np.exp(log_k)
    m0, m2 = np.trapezoid(radial, log_k), np.trapezoid(radial * angular_frequency(np.exp(log_k), np.inf) ** 2, log_k)
    np.testing.assert_allclose(np.sum(v), m0, rtol=1e-5)
    np.testing.assert_allclose(np.sum(v * omega**2), m2, rtol=5e-3)  # the ragged rim
    period = 2.0 * np.pi * np.sqrt(np.mean(squares, axis=0)[0] / np.mean(squares, axis=0)[1])
    relative = 0.5 * (pairs_error(v, np.ones_like(k)) / m0 + pairs_error(v, omega**2) / m2) / np.sqrt(seeds)
    assert abs(period / (2.0 * np.pi * np.sqrt(m0 / m2)) - 1.0) < 4.0 * relative


@pytest.mark.parametrize("exponent", [4.0, 40.0])
def test_a_buoy_finds_mean_direction_and_spread(exponent):
    """Kuik, van Vledder & Holthuijsen 1988 from η and both slopes in time at a place, near the peak frequency."""
    waves = jonswap(spreading_exponent=exponent, wave_from_deg=120.0)
    t = 0.5 * np.arange(256)
    x, y = np.random.default_rng(1).uniform(0.0, EXTENT, (2, 8))
    frequency = np.fft.rfftfreq(t.size, 0.5)
    window = np.hanning(t.size)
    band = np.abs(frequency - 1.0 / 5.5) < 0.05
    found, seas = [], [realize(sea_of(waves), seed) for seed in range(12)]
    for sea in seas:
        elevation, slopes = sea.elevation(x[:, None], y[:, None], t), sea.slopes(x[:, None], y[:, None], t)
        height, east, north = (np.fft.rfft(window * each)[:, band] for each in (elevation, *np.moveaxis(slopes, -1, 0)))
        # A wave along +k has the slope ik η, and the transform turns its exp(−iωt) about: −ik η.
        level = np.sqrt(np.sum(np.abs(height) ** 2) * np.sum(np.abs(east) ** 2 + np.abs(north) ** 2))
        a, b = (np.sum(np.imag(height * np.conj(slope))) / level for slope in (east, north))
        found.append((a, b))
    a, b = np.mean(found, axis=0)
    toward = unit_from_azimuth(300.0)
    along, across = a * toward[0] + b * toward[1], a * toward[1] - b * toward[0]
    error = np.std(found, axis=0).max() / np.sqrt(11)
    # First moment of cos^2s(θ/2), times ⟨k⟩/√⟨k²⟩ of the waves in the band.
    _, _, k, v = lattice(seas[0])
    v = v * (np.abs(angular_frequency(k, np.inf) / (2.0 * np.pi) - 1.0 / 5.5) < 0.05)
    expected = exponent / (exponent + 1.0) * np.sum(v * k) / np.sqrt(v.sum() * np.sum(v * k**2))
    # Four standard errors over seeds.
    assert abs(across) < 4.0 * error
    assert abs(along - expected) < 4.0 * error
    assert error < 0.035


# -------------------------------------------------------------------------------------------------- the expected plane


ANNULI = {
    **{f"jonswap {name}": jonswap(spreading=name, wave_from_deg=250.0) for name in SPREADINGS},
    "jonswap sharp": jonswap(spreading_exponent=80.0, wave_from_deg=250.0),
    "tma": TmaWaves(
        spectrum="tma", significant_wave_height_m=1.0, peak_period_s=5.5, spreading="mitsuyasu", wave_from_deg=250.0
    ),
    "elfouhaily": elfouhaily(wave_from_deg=250.0),
    "pierson_moskowitz": PiersonMoskowitzWaves(
        spectrum="pierson_moskowitz", wind_speed_m_s=7.0, wave_from_deg=250.0, inverse_wave_age=1.2
    ),
    "file": FileWaves(spectrum="file", file=SWAN),
}


@pytest.mark.parametrize("name", ANNULI)
def test_each_annulus_of_the_plane_holds_what_the_continuous_density_holds(name):
    depth = 6.0 if name == "tma" else np.inf
    sea = realize(sea_of(ANNULI[name], resolution_m=1.6, extent_m=512.0, depth_m=depth), 1)
    system = spectral_system(ANNULI[name], depth)
    assert system.spreading is not None
    east, north, k, v = lattice(sea)
    step, azimuth = 2.0 * np.pi / 512.0, np.arctan2(east, north)
    edges = step * np.array([6.5, 10.5, 16.5, 24.5, 40.5, 64.5, 100.5, 150.5])
    angle = 2.0 * np.pi * (np.arange(1440) + 0.5) / 1440
    for low, high in pairwise(edges):
        inside = (k >= low) & (k < high)
        fine = np.linspace(low, high, 401)[:, None]
        density = system.radial(fine) * system.spreading(fine, np.cos(angle), np.sin(angle)) * (2.0 * np.pi / 1440)
        variance = np.trapezoid(density.sum(axis=1), fine[:, 0])
        # The spreading alone: its sum over the circle is 1 at each k (a half plane's edge is midway between angles).
        np.testing.assert_allclose(density.sum(axis=1), system.radial(fine)[:, 0], rtol=2e-3)
        # The annulus is ragged: of the n waves that its rim cuts, some √(n/12) too many or too few are inside.
        # n counts the waves that the spreading reaches. Four standard deviations, as of any chance.
        ragged = 0.0
        for rim, ring in ((low, density[0]), (high, density[-1])):
            reached = 2.0 * np.pi * rim / step * ring.sum() ** 2 / (ring.size * np.sum(ring**2))
            ragged = np.hypot(ragged, ring.sum() * step / np.sqrt(12.0 * reached) / variance)
        assert abs(v[inside].sum() / variance - 1.0) < 4.0 * ragged
        assert ragged < 0.08
        # Mean vector of travel, east and north: direction and spread at once.
        toward = np.arctan2(*system.toward)
        mean = np.sum(v[inside] * np.exp(1j * azimuth[inside])) / v[inside].sum()
        wanted = np.trapezoid((density * np.exp(1j * (toward - angle))).sum(axis=1), fine[:, 0]) / variance
        assert abs(mean - wanted) < ragged
        if name != "file":
            np.testing.assert_allclose(np.degrees(np.angle(mean)), 70.0, atol=np.degrees(ragged))


# ---------------------------------------------------------------------------------------------------- distributions


@pytest.mark.parametrize("name", WAVES)
def test_a_linear_sea_is_gaussian(name):
    moments = []
    for sea in many_seas(name):
        scaled = np.stack([whole_patch(sea, t) for t in (0.0, 40.0)]) / sea.resolved.elevation_std
        slope = whole_patch(sea, 0.0, "slopes")[..., 0] / sea.resolved.slope_std_east
        moments.append([np.mean(scaled**3), np.mean(scaled**4) - 3.0, np.mean(slope**3), np.mean(slope**4) - 3.0])
    mean, error = np.mean(moments, axis=0), np.std(moments, axis=0) / np.sqrt(SEEDS - 1)
    # Over seeds, the variance that each one happens to have included: it makes up most of the fourth moment's scatter.
    assert np.all(np.abs(mean) < 4.0 * error)
    assert np.all(error < [0.03, 0.3, 0.03, 0.3])


@cache
def long_records(seeds=20, places=8, duration=250.0):
    """Records (seed, place, time), 0.2 s apart, of long-crested seas, each scaled by its own drawn rms; and a sea."""
    t, x = 0.2 * np.arange(round(duration / 0.2)), 8192.0 * np.arange(places) / places
    records, seas = (
        [],
        [realize(sea_of(jonswap(spreading="long_crested"), extent_m=2048.0), seed) for seed in range(seeds)],
    )
    for sea in seas:
        drawn = np.sqrt(0.5 * np.sum(np.abs(sea.components().amplitude) ** 2))
        records.append(sea.elevation(x[:, None], 0.0, t) / drawn)
    return np.stack(records), seas[0]


def crest_to_trough(record):
    """Heights between upward crossings of zero."""
    up = np.flatnonzero((record[:-1] < 0.0) & (record[1:] >= 0.0)) + 1
    return [np.ptp(record[start:stop]) for start, stop in pairwise(up)]


def test_wave_heights_follow_rayleigh_with_the_band_width_of_longuet_higgins():
    """Zero-crossing heights: ⟨H²⟩ = 8 m0 (1 − 0.734 ν²), ν² = m0 m2/m1² − 1 (Longuet-Higgins 1980), and their tail."""
    records, sea = long_records()
    density = sea.spectrum.line_density.to_numpy()[0]
    omega = angular_frequency(sea.spectrum.k, np.inf)
    m0, m1, m2 = (np.trapezoid(density * omega**n, sea.spectrum.k) for n in range(3))
    band = m0 * m2 / m1**2 - 1.0
    heights = [np.concatenate([crest_to_trough(record) for record in of_one]) for of_one in records]
    squares = np.array([np.mean(each**2) for each in heights]) / 8.0
    error = np.std(squares) / np.sqrt(squares.size - 1)
    # Four standard errors over seeds, and the next order of the band width.
    assert abs(np.mean(squares) - (1.0 - 0.734 * band)) < 4.0 * error + band**2
    assert 1.0 - np.mean(squares) > 4.0 * error  # the plain Rayleigh law, ⟨H²⟩ = 8 m0, is told apart
    every = np.concatenate(heights)
    every /= np.sqrt(np.mean(every**2))
    # Exceedance exp(−h²) of the rms height; where the band is wide the tail is thinner, by ν² of itself or so.
    for level in (0.5, 1.0, 1.5):
        np.testing.assert_allclose(np.mean(every > level), np.exp(-(level**2)), rtol=1.5 * band)
    # The mean period between upward crossings, one more than waves in each record, is Tm02 (Rice 1944): 9000 waves
    # leave ν/√9000 = 0.3 %, and as much again comes from each seed's own spectrum.
    crossings = every.size + records.shape[0] * records.shape[1]
    np.testing.assert_allclose(records.size * 0.2 / crossings, 2.0 * np.pi * np.sqrt(m0 / m2), rtol=0.015)


def test_the_envelope_is_rayleigh():
    records, _ = long_records()
    envelope = np.abs(hilbert(records, axis=-1))[..., 100:-100]  # without the ends, where the record is no period
    for level in (1.0, 2.0, 3.0):
        share = np.mean(envelope > level, axis=(1, 2))
        # P(R > r) = exp(−r²/2m0) of a Gaussian sea; four standard errors over seeds.
        error = np.std(share) / np.sqrt(share.size - 1)
        assert abs(np.mean(share) - np.exp(-0.5 * level**2)) < 4.0 * error
        assert error < 0.1 * np.mean(share)


def test_the_spectrum_in_time_peaks_at_its_period():
    records, _ = long_records()
    power = np.abs(np.fft.rfft(np.hanning(records.shape[-1]) * records)) ** 2
    smooth = np.convolve(np.mean(power, axis=(0, 1)), np.ones(5) / 5.0, mode="same")
    # The peak of γ = 3.3 is 7 to 9 % wide: found within half of that.
    found = np.fft.rfftfreq(records.shape[-1], 0.2)[np.argmax(smooth)]
    np.testing.assert_allclose(found, 1.0 / 5.5, rtol=0.04)


# ------------------------------------------------------------------------------------------------------- dispersion


DISPERSION = {
    "deep": sea_of(jonswap(wave_from_deg=250.0)),
    "5 m deep": sea_of(jonswap(wave_from_deg=250.0, significant_wave_height_m=0.5), depth_m=5.0),
    "current": sea_of(jonswap(wave_from_deg=250.0), current_m_s=1.5, current_toward_deg=70.0),
    "against": sea_of(jonswap(wave_from_deg=250.0), current_m_s=0.5, current_toward_deg=200.0),
    "elfouhaily": sea_of(elfouhaily(wave_from_deg=10.0)),
    "file": sea_of(FileWaves(spectrum="file", file=SWAN), depth_m=8.0),
}


@pytest.mark.parametrize("name", DISPERSION)
def test_energy_lies_on_the_dispersion_relation_on_the_side_of_travel(name):
    """The transform in x, y and t of 60 s: for each k all energy at ω(k) + k·U, within what 60 s resolve."""
    settings, duration, count = DISPERSION[name], 60.0, 192
    sea = realize(settings, 2)
    t = duration * np.arange(count) / count
    places = EXTENT * np.arange(SIDE) / SIDE
    record = sea.elevation(places[None, :, None], places[:, None, None], t) * np.hanning(count)
    power = np.abs(np.fft.fftn(record)) ** 2  # exp(i(k·x − ωt)) is found at +k and −ω
    k = 2.0 * np.pi * np.fft.fftfreq(SIDE, EXTENT / SIDE)
    omega = -2.0 * np.pi * np.fft.fftfreq(count, duration / count)
    north, east = k[:, None], k[None, :]
    carried = sea.current[0] * east + sea.current[1] * north
    curve = angular_frequency(np.hypot(north, east), settings.depth_m) + carried
    # Both halves hold the real field: a wave that runs along +k is at (k, ω) and at (−k, −ω).
    mirrored = -angular_frequency(np.hypot(north, east), settings.depth_m) + carried
    bin_ = 2.0 * np.pi / duration
    width = 2.5 * bin_  # the window's main lobe is two bins to either side, and holds 99.9 %
    ahead = np.abs(omega - curve[..., None]) < width
    near = ahead | (np.abs(omega - mirrored[..., None]) < width)
    assert power[near].sum() > 0.99 * power.sum()
    assert near.mean() < 0.1  # by chance no more would be there
    # Of the half with k towards where the sea goes, as much as runs along +k as the expected spectrum says.
    wave_east, wave_north, _, v = lattice(sea)
    toward = np.sum(v * wave_east), np.sum(v * wave_north)
    forward = (toward[0] * east + toward[1] * north)[..., None] > 0.0
    expected = v[toward[0] * wave_east + toward[1] * wave_north > 0.0].sum() / v.sum()
    found = power[ahead & forward].sum() / power[forward & near].sum()
    # A share of a thousandth runs back: of one seed it is known to a few times itself.
    assert abs(found - expected) < 5e-3
    assert expected > 0.99


def test_wavenumbers_of_the_record_are_those_of_its_periods():
    """The longest peak that is seen: k of the strongest wave of a narrow swell, from its period."""
    sea = realize(sea_of(jonswap(peak_period_s=7.0, peak_enhancement=20.0, spreading_exponent=200.0)), 4)
    power = np.abs(np.fft.fft2(whole_patch(sea, 0.0))) ** 2
    row, column = np.unravel_index(np.argmax(power), power.shape)
    k = 2.0 * np.pi / EXTENT * np.hypot(np.fft.fftfreq(SIDE, 1 / SIDE)[row], np.fft.fftfreq(SIDE, 1 / SIDE)[column])
    # One step of the lattice either side.
    assert abs(k - float(wavenumber(2.0 * np.pi / 7.0, np.inf))) < 2.0 * np.pi / EXTENT
