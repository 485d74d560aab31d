"""Antennas: energy on the sphere, directivity in closed form, Taylor's sidelobes, beam widths."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar
from scipy.special import erfc

from seamap_rt.conventions import SPEED_OF_LIGHT, db
from seamap_rt.radar.antenna import Antenna, Cut, antenna, antenna_of, directivity
from seamap_rt.radar.array import antenna_array
from seamap_rt.settings import AntennaSettings, PlacedAntenna, RadarSettings

FREQUENCY = 10e9
WAVELENGTH = SPEED_OF_LIGHT / FREQUENCY


def uniform(aperture_m: float) -> Cut:
    return lambda cosine: np.sinc(aperture_m / WAVELENGTH * np.asarray(cosine))


def gaussian_at(peak_deg: float, beamwidth_deg: float) -> Cut:
    def cut(cosine: np.ndarray) -> np.ndarray:
        angle = np.degrees(np.arcsin(np.clip(cosine, -1.0, 1.0))) - peak_deg
        return 2.0 ** (-2.0 * (angle / beamwidth_deg) ** 2)

    return cut


def cosine_cut(cosine: np.ndarray) -> np.ndarray:
    return np.sqrt(np.clip(1.0 - np.asarray(cosine) ** 2, 0.0, 1.0))


def flat_cut(cosine: np.ndarray) -> np.ndarray:
    return np.ones_like(cosine)


@pytest.fixture
def lopsided(tmp_path: Path) -> str:
    """A file whose beams stand beside boresight, with a shoulder on one side of either."""
    lines = ["cut,angle_deg,gain_db"]
    for name, peak, width in (("azimuth", 2.0, 4.0), ("elevation", -7.0, 25.0)):
        angle = np.linspace(-90.0, 90.0, 361)
        main = 2.0 ** (-4.0 * ((angle - peak) / width) ** 2)
        shoulder = 0.05 * 2.0 ** (-4.0 * ((angle - peak - 2.0 * width) / width) ** 2)
        lines += [f"{name},{a:g},{g:.4f}" for a, g in zip(angle, db(main + shoulder + 1e-5), strict=True)]
    path = tmp_path / "lopsided.csv"
    path.write_text("\n".join(lines))
    return str(path)


# --------------------------------------------------------------------------------------------------------- energy, gain


def total_gain(beam: Antenna) -> float:
    """Mean of the gain over the sphere, by the midpoint rule over 0.1° × 0.25°: 1 if energy is conserved."""
    offset = np.radians((np.arange(3600) + 0.5) * 0.1 - 180.0)
    elevation = np.radians((np.arange(720) + 0.5) * 0.25 - 90.0)
    total = sum(float(np.sum(beam.voltage(offset, up) ** 2)) * np.cos(up) for up in elevation)
    return beam.gain * total * np.radians(0.1) * np.radians(0.25) / (4.0 * np.pi)


@pytest.mark.parametrize("tilt", [0.0, 12.0])
@pytest.mark.parametrize("pattern", ["slotted_waveguide", "gaussian", "isotropic", "file"])
def test_energy_is_conserved_on_the_sphere(pattern: str, tilt: float, lopsided: str) -> None:
    settings = AntennaSettings(pattern=pattern, file=lopsided if pattern == "file" else None)  # type: ignore[arg-type]
    # 2e-6 at most measured: where the spline of the file's points kinks
    assert total_gain(antenna_of(settings, FREQUENCY, tilt)) == pytest.approx(1.0, abs=2e-5)


def test_an_antenna_on_its_back_hears_what_its_aperture_faces() -> None:
    broad = Antenna(flat_cut, flat_cut, 2.0, np.radians(60.0))
    # it looks 60° down, so that straight down is ahead, and even a little backwards of it; straight up is behind
    offset, elevation = np.radians([[0.0, 180.0, 180.0, 0.0, 0.0], [-90.0, -80.0, -25.0, 80.0, 25.0]])
    np.testing.assert_array_equal(broad.voltage(offset, elevation), [1.0, 1.0, 0.0, 0.0, 1.0])


@pytest.mark.parametrize(("width", "height"), [(1.0, 0.1), (0.5, 0.5), (1.0, 0.02)])
def test_directivity_of_a_uniform_aperture(width: float, height: float) -> None:
    # Exactly: ∫|E|² dΩ over the half space ahead is that of the aperture's autocorrelation with 2π sin(kr)/(kr).
    k = 2.0 * np.pi / WAVELENGTH
    x, x_weight = np.polynomial.legendre.leggauss(400)
    y, y_weight = np.polynomial.legendre.leggauss(150)
    x, y = 0.5 * width * (x[:, None] + 1.0), 0.5 * height * (y + 1.0)
    kernel = (width - x) * (height - y) * np.sinc(k * np.hypot(x, y) / np.pi)
    solid_angle = 2.0 * np.pi * float(x_weight @ kernel @ y_weight) / (width * height)
    exact = 4.0 * np.pi / solid_angle
    # 4e-8 measured; an elevation cut of less than a wavelength is not 0 at its ends
    assert directivity(uniform(width), uniform(height)) == pytest.approx(exact, rel=1e-6)


def test_large_aperture_limit() -> None:
    area_gain = float(db(4.0 * np.pi * 1.0 * 0.1 / WAVELENGTH**2))
    assert area_gain == pytest.approx(31.456, abs=5e-4)
    # What a height of 3.3 wavelengths adds to it: 0.0120 dB, by the exact sum of the test above.
    assert db(directivity(uniform(1.0), uniform(0.1))) - area_gain == pytest.approx(0.0120, abs=5e-5)


@pytest.mark.parametrize(("azimuth", "elevation"), [(1.8, 18.0), (1.8, 2.0), (0.06, 0.6), (0.3, 18.0)])
def test_directivity_of_gaussian_beams(azimuth: float, elevation: float) -> None:
    # 16 ln 2/(θa θe): cos ε of the solid angle and 1/cos ε of the narrowing ridge cancel. At 18° that leaves 2e-6.
    closed = 16.0 * np.log(2.0) / np.radians(azimuth) / np.radians(elevation)
    found = antenna_of(
        AntennaSettings(pattern="gaussian", azimuth_beamwidth_deg=azimuth, elevation_beamwidth_deg=elevation),
        FREQUENCY,
        0.0,
    ).gain
    assert found == pytest.approx(closed, rel=1e-5)
    if (azimuth, elevation) == (1.8, 18.0):
        assert db(found) == pytest.approx(30.5, abs=0.01)


def test_directivity_of_what_hears_broadly() -> None:
    # Ahead only: 2 for a hemisphere, 3 for a cosine (twice the short dipole's 1.5), whichever cut it is.
    assert directivity(flat_cut, flat_cut) == pytest.approx(2.0, rel=1e-10)
    assert directivity(flat_cut, cosine_cut) == pytest.approx(3.0, rel=1e-10)
    assert directivity(cosine_cut, flat_cut) == pytest.approx(3.0, rel=1e-10)
    # ∫ cos²ε cos ε (1 − cos²ε sin²α) dα dε = π (4/3 − 8/15), so 5
    assert directivity(cosine_cut, cosine_cut) == pytest.approx(5.0, rel=1e-10)
    assert antenna_of(AntennaSettings(pattern="isotropic"), FREQUENCY, 0.0).gain == 1.0


@pytest.mark.parametrize("peak", [-40.0, 5.0, 20.0])
def test_directivity_of_a_beam_beside_boresight_is_the_same_in_either_cut(peak: float) -> None:
    # The solid angle does not know one axis of the aperture from the other; the quadrature does.
    beside, ahead = gaussian_at(peak, 1.5), gaussian_at(0.0, 10.0)
    assert directivity(beside, ahead) == pytest.approx(directivity(ahead, beside), rel=1e-6)
    assert directivity(beside, ahead) == pytest.approx(directivity(gaussian_at(-peak, 1.5), ahead), rel=1e-6)


def test_gain_is_directivity_less_ohmic_loss_or_as_told() -> None:
    plain = antenna(RadarSettings())
    lossy = antenna_of(AntennaSettings(ohmic_loss_db=0.7), FREQUENCY, 0.0)
    assert db(plain.gain / lossy.gain) == pytest.approx(0.7, abs=1e-12)
    assert plain.gain == directivity(plain.azimuth, plain.elevation)
    told = antenna_of(AntennaSettings(ohmic_loss_db=0.7, gain_dbi=28.0), FREQUENCY, 0.0)
    assert db(told.gain) == pytest.approx(28.0, abs=1e-12)


# ------------------------------------------------------------------------------------------------- widths and sidelobes


@pytest.mark.parametrize("beam", [(1.8, 18.0), (2.5, 20.0), (10.0, 60.0)])
def test_beam_widths_are_those_asked_for(beam: tuple[float, float]) -> None:
    for pattern in ("slotted_waveguide", "gaussian"):
        settings = AntennaSettings(pattern=pattern, azimuth_beamwidth_deg=beam[0], elevation_beamwidth_deg=beam[1])  # type: ignore[arg-type]
        found = antenna_of(settings, FREQUENCY, 0.0)
        # Roots to 1e-12°, and the taper's own to 1e-12.
        assert found.azimuth_beamwidth_deg == pytest.approx(beam[0], abs=1e-9)
        assert found.elevation_beamwidth_deg == pytest.approx(beam[1], abs=1e-9)
        half = np.radians(beam) / 2.0
        np.testing.assert_allclose(found.voltage([half[0], -half[0]], 0.0) ** 2, 0.5, rtol=1e-10)
        np.testing.assert_allclose(found.voltage(0.0, [half[1], -half[1]]) ** 2, 0.5, rtol=1e-10)


def test_beam_width_is_measured_about_the_peak() -> None:
    beside = Antenna(gaussian_at(4.0, 2.0), gaussian_at(-80.0, 30.0), 1.0, 0.0)
    assert beside.azimuth_beamwidth_deg == pytest.approx(2.0, abs=1e-9)
    assert beside.elevation_beamwidth_deg == np.inf  # its lower half-power point would lie at −95°
    whole = antenna_of(AntennaSettings(pattern="isotropic"), FREQUENCY, 0.0)
    assert (whole.azimuth_beamwidth_deg, whole.elevation_beamwidth_deg) == (np.inf, np.inf)
    dipole = Antenna(flat_cut, cosine_cut, 3.0, 0.0)
    assert dipole.elevation_beamwidth_deg == pytest.approx(90.0, abs=1e-9)


@pytest.mark.parametrize("beam", [(1.8, 18.0), (1.8, 20.0), (2.2, 24.0)])
def test_sidelobes_and_nulls_of_taylors_one_parameter_family(beam: tuple[float, float]) -> None:
    settings = AntennaSettings(azimuth_beamwidth_deg=beam[0], elevation_beamwidth_deg=beam[1])
    found = antenna_of(settings, FREQUENCY, 0.0)
    for cut, aperture, width in ((found.azimuth, 1.0, beam[0]), (found.elevation, 0.1, beam[1])):
        length = aperture / WAVELENGTH
        u_half = length * np.sin(np.radians(width) / 2.0)

        def over_half_power(b: float, u_half: float = u_half) -> float:
            root = np.emath.sqrt(b**2 - u_half**2)
            return float(np.real(np.sinc(1j * root) / np.sinc(1j * b))) - np.sqrt(0.5)

        b = float(brentq(over_half_power, 0.3, 3.0, xtol=1e-13))  # type: ignore[arg-type]

        def level(u: float, cut: Cut = cut, length: float = length) -> float:
            return float(cut(np.array([u / length]))[0])

        for order in (1, 2, 3):
            place = np.hypot(order, b)
            if place < length:
                null = brentq(level, place - 0.05, min(place + 0.05, length), xtol=1e-12)
                assert null == pytest.approx(place, abs=1e-9)
        # The sidelobe is flat at its top: its place is found to the root of the precision, its level fully.
        lobe = minimize_scalar(level, bounds=(np.hypot(1.0, b), np.hypot(2.0, b)), options={"xatol": 1e-9})
        assert lobe.x == pytest.approx(np.hypot(1.430297, b), abs=1e-5)  # tan πx = πx
        down = 13.2615 + 20.0 * np.log10(np.sinh(np.pi * b) / (np.pi * b))
        assert -20.0 * np.log10(-lobe.fun) == pytest.approx(down, abs=1e-4)  # digits of 13.2615


def test_the_studys_first_sidelobes_are_as_the_docstring_says() -> None:
    found = antenna(RadarSettings())
    angle = np.linspace(0.0, 60.0, 60_001)
    for cut, null, place, level in ((found.azimuth, 2.2, 2.8, -21.3), (found.elevation, 22.6, 29.4, -21.0)):
        power = cut(np.sin(np.radians(angle))) ** 2
        beyond = angle > null + 0.1
        top = np.argmax(np.where(beyond, power, 0.0))
        assert angle[top] == pytest.approx(place, abs=0.05)
        assert db(power[top]) == pytest.approx(level, abs=0.05)


# ---------------------------------------------------------------------------------------------- how antennas are chosen


def test_a_placed_antenna_is_as_any_other_of_its_kind() -> None:
    placed = PlacedAntenna(offset_m=(0.1, 0.0, 0.4), azimuth_beamwidth_deg=2.4)
    common = AntennaSettings(azimuth_beamwidth_deg=2.4)
    one, other = antenna_of(placed, FREQUENCY, 5.0), antenna_of(common, FREQUENCY, 5.0)
    assert one == other  # the very same cuts: they are kept
    assert one.tilt == pytest.approx(np.radians(5.0))
    assert antenna(RadarSettings(antenna=common, tilt_deg=5.0)) == other
    assert antenna_of(common, 9.3e9, 5.0).azimuth is not other.azimuth


def test_a_beam_too_narrow_for_its_aperture_is_refused() -> None:
    with pytest.raises(ValueError, match=r"^beam width 1\.2° is narrower than a uniform aperture of 1 m gives .*$"):
        antenna_of(AntennaSettings(azimuth_beamwidth_deg=1.2), FREQUENCY, 0.0)


def test_a_pattern_s_power_lies_where_its_integral_says() -> None:
    gaussian = antenna_array(RadarSettings.model_validate({"antenna": {"pattern": "gaussian"}})).first_antenna
    # Of exp(−8 ln 2 (θ/b)²); a sum in steps of 1/200 of the beam.
    assert gaussian.share_beyond(0.5) == pytest.approx(erfc(math.sqrt(2.0 * math.log(2.0))), rel=0.02)
    waveguide = antenna_array(RadarSettings()).first_antenna
    shares = [waveguide.share_beyond(beams) for beams in (0.0, 1.0, 3.0)]
    assert shares[0] > 0.99 > shares[1] > shares[2] > 0.0
