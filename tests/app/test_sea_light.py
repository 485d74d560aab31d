"""Light on the sea: Lambert's law, and what one sees from the mast by the horizon of each vertical plane."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from seamap_rt.app.sea_view import lambert, mast_picture, sight_lines, sun

_SIDE = np.arange(-200.0, 201.0, 2.0)
_FLAT = np.zeros((_SIDE.size, _SIDE.size))
_MAST_M = 6.0


def test_a_slope_towards_the_sun_is_brightest_and_one_away_from_it_has_the_skys_share_alone() -> None:
    """A plane that rises away from the sun by as much as the sun is lower than the zenith faces it: cosine 1."""
    east = np.broadcast_to(_SIDE, _FLAT.shape)
    to_sun = sun(270.0, 30.0)  # in the west
    facing = lambert(np.tan(np.radians(60.0)) * east, _SIDE, _SIDE, to_sun)
    away = lambert(-np.tan(np.radians(60.0)) * east, _SIDE, _SIDE, to_sun)
    flat = lambert(_FLAT, _SIDE, _SIDE, to_sun)
    np.testing.assert_allclose(facing, 1.0, atol=1e-12)
    np.testing.assert_allclose(away, 0.45, atol=1e-12)  # the sun stands below it
    np.testing.assert_allclose(flat, 0.45 + 0.55 * np.sin(np.radians(30.0)), atol=1e-12)
    np.testing.assert_allclose(
        lambert(0.2 * east, _SIDE, _SIDE, to_sun, 3.0), lambert(0.6 * east, _SIDE, _SIDE, to_sun)
    )


def test_a_flat_sea_is_seen_where_the_line_of_sight_meets_it() -> None:
    """Ground range = height of the eye over the tangent of the line's depression; to the step of the rays, 0.6 %."""
    seen = sight_lines(_FLAT, _SIDE, _SIDE, _MAST_M, 90.0)
    pixel = 2.0 * np.tan(np.radians(35.0)) / 959.0
    down = pixel * (np.arange(400) + 0.5 - 0.2 * 400)  # below the horizon, for each metre ahead
    assert np.isnan(seen.ahead[down < 0.0]).all()  # the sky
    below = (down > _MAST_M / 180.0) & (down > 0.0)
    wanted = np.broadcast_to((_MAST_M / down[below])[:, None], seen.ahead[below].shape)
    np.testing.assert_allclose(seen.ahead[below], wanted, rtol=0.007)
    assert np.isinf(seen.ahead[(down > 0.0) & (down < _MAST_M / 290.0)]).all()  # beyond the map
    middle = seen.ahead.shape[1] // 2
    np.testing.assert_allclose(seen.east[below, middle], seen.ahead[below, middle], rtol=1e-3)
    np.testing.assert_allclose(seen.north[below, middle], 0.0, atol=0.3)


@pytest.mark.parametrize("look", [0.0, 90.0, 215.0])
def test_a_crest_hides_what_lies_behind_it_as_far_as_its_ray_reaches(look: float) -> None:
    """A ring of 2 m at 60 to 64 m hides the flat sea out to h r/(h − 2) = 96 m, in each direction."""
    distance = np.hypot(*np.meshgrid(_SIDE, _SIDE))
    height = np.where((distance >= 60.0) & (distance <= 64.0), 2.0, 0.0)
    seen = sight_lines(height, _SIDE, _SIDE, _MAST_M, look)
    ground = np.hypot(seen.east, seen.north)[np.isfinite(seen.ahead)]
    hidden = (ground > 67.0) & (ground < 92.0)  # within a cell or two of the ring and its shadow
    assert not hidden.any()
    assert ((ground > 58.0) & (ground < 65.0)).any()
    assert ((ground > 98.0) & (ground < 110.0)).any()


def test_the_picture_is_brighter_in_the_sky_and_grey_where_nothing_is_known() -> None:
    known = np.ones(_FLAT.shape, dtype=bool)
    whole = _pixels(mast_picture(_FLAT, _SIDE, _SIDE, known, _MAST_M, 0.0))
    assert whole.shape == (400, 960, 3)
    assert whole[:60].mean() > whole[100:].mean() + 50.0
    assert whole[200:, :, 2].mean() > whole[200:, :, 0].mean() + 20.0  # water is blue
    holed = _pixels(mast_picture(_FLAT, _SIDE, _SIDE, ~known, _MAST_M, 0.0))
    assert np.ptp(holed[300, 480]) < np.ptp(whole[300, 480])
    np.testing.assert_array_equal(holed[:70], whole[:70])


def _pixels(jpeg: bytes) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(jpeg)), dtype=float)
