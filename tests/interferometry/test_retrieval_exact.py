"""Exact echoes give exact heights: whatever the mode, the baseline, the height of the mast and the boat's attitude.

The surface is flat or curved in closed form, each gate hears one point of it, and there is no noise: every cell that
holds a height must lie on that surface.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from seamap_rt.dataset import QUALITY_FLAGS
from seamap_rt.interferometry import retrieve
from seamap_rt.interferometry.description import RadarDescription
from seamap_rt.interferometry.retrieval import retrieve_turn
from seamap_rt.settings import RadarSettings, RetrievalSettings
from validation import analytic
from validation.analytic.seas import Surface

Array = NDArray[np.float64]
WAVELENGTH = 299_792_458.0 / 10e9
LOOK = np.radians(1.8)
SPACING = 1.5  # m, of gates
TRANSMIT: tuple[Literal["single", "switched"], ...] = ("single", "switched")
INTERFEROGRAM: tuple[Literal["single_pulse", "alternating_pulse"], ...] = ("single_pulse", "alternating_pulse")
MODES = [(transmit, interferogram) for transmit in TRANSMIT for interferogram in INTERFEROGRAM]
SMALL = {  # windows of one gate and one look: nothing is averaged over what bends
    "cell_range_m": SPACING,
    "window_range_m": SPACING,
    "window_azimuth_deg": 1.8,
    "paths": "one_way",  # what the modes' own interferograms tell
    "ground_m": 1000.0,  # the ground map is not looked at here
}
ESTIMATORS = ["adaptive", "single_cell", "sliding_plane"]


TALLEST = 12.0  # m: the mean place of a look's arc lies R · LOOK²/24 within it, which is 0.5 mm on a plane so high


@dataclass(frozen=True)
class Case:
    """A radar, how its boat lies, and the sea's direction and size, as a share of what is not ambiguous."""

    radar: RadarSettings
    attitude: tuple[float, float, float]
    place: tuple[float, float, float]
    toward: float
    share: float

    @property
    def paths(self) -> int:
        return 2 if (self.radar.transmit, self.radar.interferogram) == ("switched", "alternating_pulse") else 1

    @property
    def rise(self) -> float:
        """Of the highest sea, over its range. Half an ambiguity, beyond which one phase cannot tell, is ½ λ/(pB) of the
        range times cos ε/cos η, ε the elevation and η that off the boresight: 0.69 at 56° down and 20° of tilt."""
        return 0.3 * WAVELENGTH / (self.paths * self.radar.baseline_m)

    @property
    def plane(self) -> analytic.TiltedSea:
        """Through mean sea level below the boat."""
        slope = self.share * min(0.03, self.rise, TALLEST / self.radar.range_m[1])
        toward = np.radians(self.toward)
        east, north = float(slope * np.sin(toward)), float(slope * np.cos(toward))
        return analytic.TiltedSea(east, north, -east * self.place[0] - north * self.place[1])

    def wave(self, long: float) -> analytic.SinusoidSea:
        """A regular wave, `long` times as long as a look is wide, and 40 m at least."""
        near, far = self.radar.range_m
        height = self.share * min(1.0, 2.0 * self.rise * near)
        return analytic.SinusoidSea(height, max(40.0, long * far * LOOK), self.toward, 10.0 * self.toward)

    def echoes(self, sea: Surface) -> xr.Dataset:
        return analytic.echoes(sea, self.radar, attitude_deg=self.attitude, position_m=self.place)


@st.composite
def cases(draw: st.DrawFn) -> Case:
    """R from max(15, 1.2 H) to 3000 m, B 0.05 to 1.8 m; half of the boats level at the origin, half of them not."""
    height = draw(st.floats(2.0, 50.0))
    near = max(15.0, 1.2 * height)
    near *= (2900.0 / near) ** draw(st.floats(0.0, 1.0))
    start = draw(st.floats(0.0, 300.0))
    attitude, place, level = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), draw(st.booleans())
    if not level:
        attitude = (draw(st.floats(-15.0, 15.0)), draw(st.floats(-10.0, 10.0)), draw(st.floats(-180.0, 180.0)))
        place = (draw(st.floats(-20.0, 20.0)), draw(st.floats(-20.0, 20.0)), draw(st.floats(-0.5, 0.5)))
    # Near by, the fan of a heeled boat meets the sea some 20° beside its bearing: a wide sector holds whole looks.
    looks = draw(st.integers(5, 9)) + (0 if level else 14)
    radar = RadarSettings(
        prf_hz=4000.0,
        sector_deg=(start, start + 1.8 * looks),
        range_m=(near, near + SPACING * draw(st.integers(20, 60))),
        height_m=height,
        baseline_m=0.05 * 36.0 ** draw(st.floats(0.0, 1.0)),
        tilt_deg=draw(st.floats(-20.0, 20.0)),
        transmit=draw(st.sampled_from(TRANSMIT)),
        interferogram=draw(st.sampled_from(INTERFEROGRAM)),
    )
    return Case(radar, attitude, place, draw(st.floats(0.0, 360.0)), draw(st.floats(-1.0, 1.0)))


@dataclass(frozen=True)
class Heights:
    """Maps (look, gate) without the outermost looks, whose pulses lack their pairs, and where cells are laid [m]."""

    fields: dict[str, Array]
    x: Array
    y: Array

    def __getitem__(self, name: str) -> Array:
        return self.fields[name]


def retrieved(case: Case, sea: Surface, **asked: object) -> Heights:
    echoes = case.echoes(sea)
    wanted = RetrievalSettings.model_validate({**SMALL, **asked})
    polar, ground = retrieve_turn(echoes, RadarDescription.of(echoes), wanted, 0)
    fields = {str(name): values.values[0, 1:-1].astype(np.float64) for name, values in polar.items() if name != "time"}
    if ground.x is not None and ground.y is not None:
        return Heights(fields, ground.x[1:-1], ground.y[1:-1])
    # At rest: along the mean azimuth of its pulses, between whose neighbours to either side each is in the middle.
    heard = np.isfinite(echoes["voltage"].values[:, 0]).any(axis=1)
    sweep = (echoes["azimuth"].values - case.radar.sector_deg[0] + 1e-6) % 360.0
    look = np.floor(sweep / 1.8).astype(int)
    means = [sweep[heard & (look == n)].mean() for n in range(1, polar.sizes["azimuth"] - 1)]
    azimuth = np.radians(case.radar.sector_deg[0] + np.array(means))[:, None]
    return Heights(fields, fields["ground_range"] * np.sin(azimuth), fields["ground_range"] * np.cos(azimuth))


@pytest.mark.parametrize("estimator", ESTIMATORS)
@settings(max_examples=40, derandomize=True, database=None)
@given(case=cases())
def test_planes(estimator: str, case: Case) -> None:
    sea = case.plane
    found = retrieved(case, sea, estimator=estimator)
    heard = np.isfinite(found["height"])
    assert heard.mean() > (0.99 if case.attitude == (0.0, 0.0, 0.0) else 0.2)
    # Asked: 1 mm. complex64 leaves 6e-8 rad, through λR/2πpB of 290 m/rad at 3 km and 0.05 m that is 0.02 mm.
    assert np.abs(found["height"] - sea.height(found.x, found.y))[heard].max() < 1e-3
    # Asked: 1e-4. Outward is from the array's middle to the cell.
    away = np.arctan2(found.x - case.place[0], found.y - case.place[1])
    outward = sea.slope_x * np.sin(away) + sea.slope_y * np.cos(away)
    clockwise = sea.slope_x * np.cos(away) - sea.slope_y * np.sin(away)
    for name, slope in (("slope_range", outward), ("slope_azimuth", clockwise)):
        # Cells that are called ambiguous have none: below a high mast the sea turns the phase too fast to be followed.
        # Nor has a gate with none but such ones before and behind.
        certain = heard & ((found["quality"].astype(int) & QUALITY_FLAGS["ambiguous"]) == 0)
        beside = np.pad(certain, ((0, 0), (1, 1)))
        certain &= beside[:, :-2] | beside[:, 2:]
        known = certain & np.isfinite(found[name])
        assert known.sum() >= 0.9 * certain.sum()
        assert np.abs(found[name] - slope)[known].max(initial=0.0) < 1e-4


@pytest.mark.parametrize("estimator", ESTIMATORS)
@settings(max_examples=25, derandomize=True, database=None)
@given(case=cases(), long=st.floats(15.0, 60.0))
def test_long_waves(estimator: str, case: Case, long: float) -> None:
    sea = case.wave(long)
    found = retrieved(case, sea, estimator=estimator)
    heard = np.isfinite(found["height"])
    # What a wave bends across a look's own width w averages to η (kw)²/24.
    width = LOOK * np.hypot(found.x - case.place[0], found.y - case.place[1])
    bent = 0.5 * abs(sea.height_m) * (2.0 * np.pi / sea.wavelength_m * width) ** 2 / 24.0
    error = np.abs(found["height"] - sea.height(found.x, found.y))
    if estimator == "adaptive" and sea.wavelength_m > 400.0:
        return  # no sea's waves: from a map of 100 m they are no more than a bent plane
    if estimator == "adaptive":  # of its neighbours it takes as much as their phases seem worth: by its own error bar
        bent = bent + 4.0 * found["height_std"]
        # Where the sea turns the phase by a radian within a pulse, neighbours may be a cycle off, as the flag says.
        heard &= (found["quality"].astype(int) & QUALITY_FLAGS["ambiguous"]) == 0
    assert (error < 1e-3 + bent)[heard].all()


@pytest.mark.parametrize(("transmit", "interferogram"), MODES)
@pytest.mark.parametrize("height", [3.0, 12.0])
@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_default_windows(
    transmit: Literal["single", "switched"],
    interferogram: Literal["single_pulse", "alternating_pulse"],
    height: float,
    estimator: str,
) -> None:
    # A window is turned along a straight line; what the phase k B H/R of mean sea level bends in it is H s²/R² of
    # height, s² the window's variance in range: 1.5 m² of three gates alike, 1.1 m² where the outer ones count half.
    radar = RadarSettings(
        prf_hz=4000.0,
        sector_deg=(20.0, 36.2),
        range_m=(max(15.0, 1.2 * height), 300.0),
        height_m=height,
        transmit=transmit,
        interferogram=interferogram,
    )
    case = Case(radar, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 70.0, 0.5)
    sea = case.plane
    default = RetrievalSettings()
    names = ("cell_range_m", "window_range_m", "window_azimuth_deg")
    found = retrieved(case, sea, estimator=estimator, **{name: getattr(default, name) for name in names})
    ranges = radar.range_m[0] + SPACING * np.arange(found.x.shape[1])
    drop = height - sea.height(found.x, found.y)
    error = found["height"] - sea.height(found.x, found.y)
    assert (np.abs(error) < 1e-3 + 1.6 * drop / ranges**2).all()


# --------------------------------------------------------------------------------------------- where geometry ends


def test_beyond_half_an_ambiguity_a_height_is_folded() -> None:
    """One phase tells heights but for whole ambiguities, λR/(pB): 1 m at 30 m with B = 0.9 m, p = 1."""
    radar = RadarSettings(prf_hz=4000.0, sector_deg=(0.0, 9.0), range_m=(60.0, 63.0), baseline_m=0.9)
    for level, folds in ((0.9, 0), (1.3, -1)):
        case = Case(radar, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0, 0.0)
        found = retrieved(case, analytic.TiltedSea(0.0, 0.0, level), estimator="single_cell", ambiguity="fold")
        ambiguity = WAVELENGTH * (60.0 + SPACING * np.arange(3)) / 0.9
        # The ambiguity bends by z/R of itself, some centimetres.
        np.testing.assert_allclose(found["height"] - level, folds * ambiguity * np.ones((3, 1)), atol=0.05)


def test_a_difference_longer_than_the_baseline_has_no_place() -> None:
    radar = RadarSettings(
        prf_hz=4000.0, sector_deg=(0.0, 9.0), range_m=(6.0, 9.0), range_sampling_m=0.25, baseline_m=0.05
    )
    echoes = analytic.echoes(analytic.FlatSea(), radar)
    turned = echoes.copy(deep=True)
    turned["voltage"][:, 0] *= np.complex64(np.exp(2.8j))
    asked = RetrievalSettings.model_validate({**SMALL, "estimator": "single_cell", "ambiguity": "fold"})
    flat, high = (retrieve(each, asked)["polar"].to_dataset().isel(turn=0) for each in (echoes, turned))
    difference = np.asarray(flat["phase_unwrapped"].values + 2.8) * WAVELENGTH / (2.0 * np.pi)
    outside = difference > 0.05 * (1.0 + 1e-6)
    assert 0.1 < outside.mean() < 0.9
    np.testing.assert_array_equal(np.isnan(high["height"].values), outside)
    np.testing.assert_array_equal(high["quality"].values & QUALITY_FLAGS["ambiguous"] > 0, outside)


def test_no_sea_is_nearer_than_the_masts_foot() -> None:
    radar = RadarSettings(prf_hz=4000.0, sector_deg=(0.0, 9.0), range_m=(15.0, 60.0), height_m=20.0)
    found = retrieve(analytic.echoes(analytic.FlatSea(), radar), RetrievalSettings.model_validate(SMALL))
    maps = found["polar"].to_dataset()
    height, quality = (maps[name].values[0] for name in ("height", "quality"))
    below = maps["range"].values < 20.0
    assert np.isnan(height[:, below]).all()
    assert (quality[:, below] & QUALITY_FLAGS["no_echo"] > 0).all()
    assert np.abs(height[:, maps["range"].values > 24.0]).max() < 1e-3
