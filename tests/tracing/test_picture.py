"""The picture from the mast: where things stand in it by the pinhole's geometry, what hides what, what it leaves."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from seamap_rt import sea
from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.mesh.surface import mesh_turn
from seamap_rt.scene import load_scene
from seamap_rt.settings import RadarSettings
from seamap_rt.tracing import tracer
from seamap_rt.tracing.picture import Elevation, Sky, View, render_from_mast

Places = NDArray[np.float64]
SMALL = View(size=(240, 160))


def flat(x: Places, y: Places) -> Places:
    return np.zeros_like(x)


def hill(azimuth: float, distance: float, height: float) -> Elevation:
    """A round hill of water, 5 m wide (standard deviation)."""
    east, north = unit_from_azimuth(azimuth)
    return lambda x, y: height * np.exp(-((x - distance * east) ** 2 + (y - distance * north) ** 2) / 50.0)


def grey(picture: NDArray[np.uint8]) -> NDArray[np.float64]:
    return picture.astype(np.float64).mean(axis=-1)


def skyline(picture: NDArray[np.uint8]) -> NDArray[np.intp]:
    """Rows of sky in each column: down to where the brightness falls by more than 15 of 255; the sky's own gradient
    is 3 a row."""
    return 1 + np.argmax(np.diff(grey(picture), axis=0) < -15.0, axis=0)


# --------------------------------------------------------------------------------------- where things stand


def test_the_eye_is_the_radars_unless_said_otherwise() -> None:
    assert View().height_m == RadarSettings().height_m


@pytest.mark.parametrize(("tilt", "height"), [(-3.0, 30.0), (0.0, 2.0), (10.0, 30.0)])
def test_the_horizon_of_a_flat_sea_is_level_and_where_the_pinhole_puts_it(tilt: float, height: float) -> None:
    view = dataclasses.replace(SMALL, tilt_deg=tilt, height_m=height)
    expected = 0.5 * view.size[1] - view.focal_length * np.tan(np.radians(tilt))
    # A row that is half water may count as sky or water; the mesh ends 1e-5 rad below level, 0.002 rows.
    assert np.abs(skyline(render_from_mast(flat, view, samples=4)) - expected).max() <= 1.0


@pytest.mark.parametrize("look", [0.0, 130.0])
def test_a_hill_stands_at_its_azimuth_and_as_high_as_it_is(look: float) -> None:
    view = dataclasses.replace(SMALL, azimuth_deg=look, tilt_deg=0.0)
    distance, height = 60.0, 12.0
    sky = Sky(sun_azimuth_deg=look - 45.0)
    rows = skyline(render_from_mast(hill(look + 12.0, distance, height), view, sky, samples=4))
    # Halfway up its flanks, because its top is flat: the mean of the columns where it is above half its height.
    columns = np.arange(view.size[0])
    raised = columns[rows < rows.max() - 0.5 * (rows.max() - rows.min())]
    ahead = distance * np.cos(np.radians(12.0))
    expected = 0.5 * view.size[0] + view.focal_length * np.tan(np.radians(12.0))
    assert abs(raised.mean() + 0.5 - expected) <= 1.0  # the flanks' ends are whole columns
    top = 0.5 * view.size[1] - view.focal_length * (height - view.height_m) / ahead
    # Half a row of rounding; the tangent touches before the top, 25 m² (7/60)²/12 ≈ 0.03 m higher: 0.1 row.
    assert abs(rows.min() - top) <= 1.0


def test_a_sinusoid_seen_along_its_crests_has_its_length() -> None:
    """The sea at x is seen v rows below the horizon in column x v/h: crests run to one vanishing point."""
    wavelength, below = 4.0, np.arange(40, 80)
    view = View(azimuth_deg=0.0, tilt_deg=0.0, size=(480, 200))
    picture = grey(
        render_from_mast(
            lambda x, y: 0.07 * np.cos(2.0 * np.pi * x / wavelength), view, Sky(sun_azimuth_deg=90.0), samples=16
        )
    )
    column = np.arange(view.size[0] // 2) + 0.5  # right of the middle: left of it the other flank of a wave is seen
    rows = picture[view.size[1] // 2 + below, view.size[0] // 2 :]
    x = column * view.height_m / (below[:, None] + 0.5)
    # What sky and Fresnel do to the rows without waves is smooth; the window keeps the edges out of the sum.
    trend = [np.polynomial.Polynomial.fit(column, row, 3)(column) for row in rows]
    signal = (rows - trend) * np.hanning(column.size)
    numbers = np.linspace(0.5, 1.7, 241) / wavelength
    power = [np.abs(np.sum(np.exp(-2j * np.pi * number * x) * signal)) for number in numbers]
    # The rows span 4 to 7 waves; that a crest stands 1.4 % nearer the eye than a trough is the larger error.
    assert_allclose(numbers[np.argmax(power)] * wavelength, 1.0, atol=0.03)


def test_turning_sea_sun_and_eye_together_changes_nothing() -> None:
    def waves(x: Places, y: Places) -> Places:
        return 0.3 * np.sin(0.4 * x + 0.2 * y) + 0.2 * np.cos(0.7 * y)

    def turned(azimuth: float) -> Elevation:
        east, north = unit_from_azimuth(azimuth)
        return lambda x, y: waves(x * north - y * east, x * east + y * north)

    pictures = [
        grey(
            render_from_mast(
                turned(angle),
                dataclasses.replace(SMALL, azimuth_deg=angle),
                Sky(sun_azimuth_deg=angle - 40.0),
                samples=16,
            )
        )
        for angle in (0.0, 75.0)
    ]
    # Rays are the same, but the frames in which a normal's roughness is drawn turn: only their noise differs.
    assert np.abs(pictures[0] - pictures[1]).mean() < 3.0
    assert abs(pictures[0].mean() - pictures[1].mean()) < 0.1
    assert np.abs(pictures[0] - pictures[0][:, ::-1]).mean() > 6.0  # the picture has something to turn


# --------------------------------------------------------------------------------------- what hides what


def test_a_hill_hides_what_is_behind_it_and_only_that() -> None:
    view = dataclasses.replace(SMALL, tilt_deg=3.0)
    front, behind, beside = hill(270.0, 40.0, 9.0), hill(270.0, 80.0, 9.0), hill(285.0, 80.0, 9.0)
    alone = render_from_mast(front, view, samples=4)
    hidden = render_from_mast(lambda x, y: front(x, y) + behind(x, y), view, samples=4)
    shown = render_from_mast(lambda x, y: front(x, y) + beside(x, y), view, samples=4)
    # The second hill rises 4 m in 80 m, the first 4 m in 40 m: no ray from the eye meets it, a few mirrored ones do.
    assert_array_equal(skyline(hidden), skyline(alone))
    changed = [np.count_nonzero(np.abs(grey(picture) - grey(alone)) > 3.0) for picture in (hidden, shown)]
    assert changed[0] < 30
    assert changed[1] > 300


def test_a_rough_sea_has_no_black_or_burnt_specks() -> None:
    made = load_scene("choppy_sea")
    realised = sea.realize(made.sea, 1)
    view = View(size=(400, 200))
    picture = render_from_mast(lambda x, y: realised.elevation(x, y, 0.0), view, samples=16)
    water = grey(picture)[int(skyline(picture).max()) + 1 :]
    neighbours = np.median([np.roll(water, step, axis) for axis in (0, 1) for step in (-1, 1)], axis=0)
    # Noise and the waves themselves stay below 60 of 255 from pixel to pixel; a black speck is 100 off.
    assert np.abs(water - neighbours)[1:-1, 1:-1].max() < 60.0
    assert water.min() > 10.0
    assert 5.0 < water.std() < 60.0  # and waves are to be seen


# ----------------------------------------------------------------------------------------- what it leaves


def test_same_seed_same_picture() -> None:
    waves = hill(270.0, 40.0, 2.0)
    first, again, other = (render_from_mast(waves, SMALL, samples=4, seed=seed) for seed in (1, 1, 2))
    assert first.dtype == np.uint8
    assert first.shape == (160, 240, 3)
    assert_array_equal(first, again)
    assert 0.0 < np.abs(grey(first) - grey(other)).mean() < 10.0  # another draw of the noise, the same sea


def test_a_picture_leaves_the_rays_of_the_radar_alone_and_they_it() -> None:
    made = load_scene("choppy_sea", overrides={"radar.sector_deg": [90.0, 95.0], "radar.range_m": [15.0, 100.0]})
    realised = sea.realize(made.sea, 1)

    def picture() -> NDArray[np.uint8]:
        return render_from_mast(lambda x, y: realised.elevation(x, y, 0.0), SMALL, samples=4)

    mesh = mesh_turn(realised, made.radar, made.tracing, 0)
    kept = tracer("facets", made.radar, made.scattering)  # its Sionna scene lives on through the pictures
    drawn_first = picture()
    before = kept(mesh).lit
    drawn_then = picture()
    after, anew = kept(mesh).lit, tracer("facets", made.radar, made.scattering)(mesh).lit
    assert before is not None
    assert 0.1 < before.mean() < 0.9
    for lit in (after, anew):
        assert_array_equal(lit, before)
    assert_array_equal(drawn_then, drawn_first)


# ---------------------------------------------------------------------------------------------- bad input


@pytest.mark.parametrize(
    ("view", "sky", "more", "message"),
    [
        ({"height_m": 0.9}, {}, {}, "height_m = 0.9: must be finite and above the water at the mast, 1.00 m; raise"),
        ({"height_m": float("nan")}, {}, {}, "height_m = nan: must be"),
        ({"height_m": float("inf")}, {}, {}, "height_m = inf: must be"),
        ({"size": (100, 0)}, {}, {}, "size = .*: must be"),
        ({"field_of_view_deg": 150.0}, {}, {}, "field_of_view_deg = 150: must be"),
        ({"tilt_deg": 70.0}, {}, {}, "tilt_deg = 70: must leave"),
        ({"tilt_deg": float("nan")}, {}, {}, "tilt_deg = nan: must leave"),
        ({}, {"sun_elevation_deg": -5.0}, {}, "sun_elevation_deg = -5: must be"),
        ({}, {"turbidity": 0.5}, {}, "turbidity = 0.5: must be"),
        ({}, {}, {"unresolved_mss": 0.0}, "unresolved_mss = 0: must be"),
        ({}, {}, {"samples": 0}, "samples = 0: must be"),
    ],
)
def test_bad_input_is_refused_in_one_line(
    view: dict[str, Any], sky: dict[str, Any], more: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=f"^{message}[^\n]*; [^\n]*$" if "raise" not in message else message) as error:
        render_from_mast(lambda x, y: np.ones_like(x), dataclasses.replace(SMALL, **view), Sky(**sky), **more)
    assert "\n" not in str(error.value)
