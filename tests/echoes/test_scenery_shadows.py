"""What a scene's objects hide of the sea at the moment of the beam: those of the world, and the boat's own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from scenery_scenes import SPEED, Array, box, lit, places, plate, scene, through_plate, traced

from seamap_rt.conventions import wrap_degrees
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.pose import boat_axes
from seamap_rt.radar.scan import pulses
from seamap_rt.scene import load_scene
from seamap_rt.simulation import Simulator
from seamap_rt.tracing import Illumination

# ------------------------------------------------------------------------------------------ shadows of the world's


@pytest.mark.parametrize("name", ["facets", "horizon"])
@pytest.mark.parametrize("turn", [0, 2])
def test_a_plate_hides_just_the_facets_behind_it(name: str, turn: int, tmp_path: Path) -> None:
    """At rest, and from a boat that has gone on 5 m east a second: every facet against the closed form."""
    made = scene(
        plate(6.0, -1.0, 2.0),
        tmp_path,
        thing={"position_m": [0.0, 30.0, 0.0]},
        radar__sector_deg=[330.0, 370.0],
        tracing__tracer=name,
        turns=3,
        **(SPEED if turn else {}),
    )
    before, after = traced(made, turn)
    assert lit(before).all()
    origin = np.zeros((before.grid.columns, 3))
    if turn:
        origin[:, 0] = 5.0 * before.grid.column_time
        assert origin[:, 0].min() > 9.0
    ends = places(before, origin)
    for antenna_number, height in enumerate((4.9, 5.1)):
        eye = (origin + np.array([0.0, 0.0, height]))[:, None]
        inside = through_plate(
            eye, ends, np.array([-3.0, 30.0, -1.0]), np.array([6.0, 0.0, 0.0]), np.array([0.0, 0.0, 3.0])
        )
        sure = np.abs(inside) > 1e-3  # a ray stops 1 mm short; rounding is 1e-6 of the plate
        assert sure.mean() > 0.999
        assert_array_equal(~lit(after)[antenna_number][sure], inside[sure] > 0.0)
        dark = ~lit(after)[antenna_number]
        north = ends[dark][:, 1]
        # From the plate to d·H/(H − h), a facet of 0.5 m cut in two at most.
        assert north.min() == pytest.approx(30.0, abs=0.5)
        assert north.max() == pytest.approx(30.0 * height / (height - 2.0), abs=0.5)


def test_the_nearest_columns_are_asked_too(tmp_path: Path) -> None:
    """An antenna 0.5 m to the side of the array's middle sees a post 3 m off 9° beside where the middle sees it."""
    made = scene(
        box((0.2, 0.2, 9.0), (0.0, 0.0, 4.5)),
        tmp_path,
        thing={"position_m": [0.0, 3.0, 0.0]},
        radar__sector_deg=[340.0, 380.0],
        radar__antennas=[{"offset_m": [-0.5, 0.0, -0.1]}, {"offset_m": [0.5, 0.0, 0.1]}],
    )
    facets, after = traced(made)
    simulator = Simulator(made)
    simulator.scenery._columns = lambda facets: np.arange(facets.grid.columns)  # type: ignore[method-assign]
    assert_array_equal(lit(after), lit(simulator.scenery.hide(facets)))
    dark = ~lit(after)[:, :, -1]
    azimuth = wrap_degrees(facets.grid.column_azimuth)
    # The array turns with the look: sin α = 0.5/3 · (1 − 3/100) where a ray to 100 m passes the post; 0.45° a column.
    for antenna_number, sign in enumerate((1.0, -1.0)):
        assert azimuth[dark[antenna_number]].mean() == pytest.approx(sign * 9.3, abs=0.45)


def test_no_light_bends_round_an_object(tmp_path: Path) -> None:
    """Over crests it does bend: behind the wall that light is gone too, and beside it nothing has changed."""
    made = scene(
        box((0.5, 6.0, 12.0), (0.0, 0.0, 0.0)),
        tmp_path,
        name="sinusoid",
        thing={"position_m": [-40.0, 0.0, 0.0]},
        radar__sector_deg=[255.0, 285.0],
        radar__range_m=[15.0, 300.0],
        tracing__diffraction="knife_edge",
    )
    before, after = traced(made)
    assert before.field is not None
    assert after.field is not None
    eye = np.array([0.0, 0.0, 4.9])
    ends = places(before, np.zeros((before.grid.columns, 3)))
    inside = through_plate(
        eye, ends, np.array([-39.75, -3.0, -6.0]), np.array([0.0, 6.0, 0.0]), np.array([0.0, 0.0, 12.0])
    )
    bent = ~lit(before)[0] & (np.abs(before.field[0]) > 0.01)
    behind, beside = inside > 0.05, (inside < -0.5) | ~np.isfinite(inside)
    assert (bent & behind).sum() > 100
    assert_array_equal(after.field[0][behind], 0.0)
    assert not lit(after)[0][behind].any()
    assert_array_equal(after.field[0][beside], before.field[0][beside])
    assert_array_equal(lit(after)[0][beside], lit(before)[0][beside])


def test_no_objects_change_nothing() -> None:
    made = load_scene("flat", {"radar.sector_deg": [0.0, 5.0], "tracing.tracer": "horizon"})
    facets, after = traced(made)
    assert after is facets
    simulator = Simulator(made)
    assert simulator.scenery.voltages(simulator.mesh(0), pulses(Installation(made.radar), 0)) is None


# ------------------------------------------------------------------------------------------ the boat's own


def hidden_bearings(facets: Illumination, heading: float) -> Array:
    """Bearings off the bow [deg] of the columns whose far end the lower antenna does not see."""
    bearing = wrap_degrees(facets.grid.column_azimuth[~lit(facets)[0][:, -1]] - heading)
    return np.unique(bearing.round(6))  # where the turn overlaps its own start a bearing comes twice


@pytest.mark.parametrize("heading", [0.0, 90.0, 200.0])
def test_the_wheelhouse_hides_the_same_sector_off_the_bow(heading: float, tmp_path: Path) -> None:
    """A post 2 m abaft and 1 m to starboard, 0.6 m wide: from 146° to 161° off the bow; the boat goes at 5 m/s."""
    made = scene(
        box((0.6, 0.02, 8.0), (0.0, 0.0, 4.0)),
        tmp_path,
        thing={"position_m": [1.0, -2.0, 0.0], "fixed_to": "boat"},
        radar__sector_deg=[0.0, 360.0],
        tracing__facet_m=2.0,
        turns=2,
        platform__heading_deg=heading,
        platform__speed_m_s=5.0,
    )
    found = hidden_bearings(traced(made, 1)[1], heading)
    start, stop = (np.degrees(np.arctan2(x, -1.99 if x > 1.0 else -2.01)) for x in (1.3, 0.7))
    # Columns are 0.45° wide, and facets stand up to a third of one beside their middle.
    assert found.min() == pytest.approx(start, abs=0.6)
    assert found.max() == pytest.approx(stop, abs=0.6)
    assert found.size == pytest.approx((stop - start) / 0.45, abs=2)


@pytest.mark.parametrize(("list_deg", "trim_deg"), [(10.0, 0.0), (-10.0, 0.0), (0.0, 8.0), (7.0, -6.0)])
def test_the_wheelhouse_turns_with_the_rolling_boat(list_deg: float, trim_deg: float, tmp_path: Path) -> None:
    """A plate ahead, as high as the antennas: where the roll takes it, facet by facet; heading east."""
    made = scene(
        plate(2.0, 2.0, 4.9),
        tmp_path,
        thing={"position_m": [1.0, 3.0, 0.0], "fixed_to": "boat"},
        radar__sector_deg=[60.0, 140.0],
        platform__heading_deg=90.0,
        platform__list_deg=list_deg,
        platform__trim_deg=trim_deg,
        platform__lever_arm_m=[0.0, 0.0, 5.0],
        radar__baseline_m=0.4,
    )
    before, after = traced(made)
    # The boat turns about the mast's foot, at the world's origin: rows are its axes, told in the world.
    axes = boat_axes((list_deg, trim_deg, 90.0))
    corner, along, up = (np.array(v) @ axes for v in ([0.0, 3.0, 2.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.9]))
    ends = places(before, np.array([0.0, 0.0, 5.0]) @ axes + np.zeros((before.grid.columns, 3)))
    dark = []
    for number, height in enumerate((4.8, 5.2)):
        inside = through_plate(np.array([0.0, 0.0, height]) @ axes, ends, corner, along, up)
        sure = np.abs(inside) > 2e-3
        assert_array_equal((lit(before) & ~lit(after))[number][sure], ((inside > 0.0) & lit(before)[number])[sure])
        dark.append((inside > 0.0).sum())
    assert dark[0] > 0


def test_starboard_goes_down_with_the_list(tmp_path: Path) -> None:
    """A rail abeam, lower than the antennas, hides less of the sea the deeper its side lies."""
    dark = {}
    for list_deg in (-8.0, 0.0, 8.0):
        made = scene(
            plate(4.0, 0.0, 4.7),
            tmp_path,
            thing={"position_m": [3.0, 0.0, 0.0], "heading_deg": 90.0, "fixed_to": "boat"},
            radar__sector_deg=[80.0, 100.0],
            platform__list_deg=list_deg,
        )
        before, after = traced(made)
        dark[list_deg] = (lit(before) & ~lit(after))[0].sum()
    assert dark[8.0] < dark[0.0] < dark[-8.0]
