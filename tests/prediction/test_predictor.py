"""From turn to turn: dark turns, gaps, a cold start, and errors that follow what came after."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import seamap_rt as sr
from seamap_rt.prediction import Observations, Predictor, WaveField
from seamap_rt.prediction.innovations import pairs_of_looks
from seamap_rt.prediction.knowledge import ModelError

TURNS = 8
SHOWN = ("height", "height_std", "dwell_height", "dwell_height_std", "radial_velocity")


@pytest.fixture(scope="module")
def polar() -> xr.Dataset:
    """Maps of eight turns of the tiny scene."""
    scene = sr.load_scene("tiny", {"turns": TURNS, "tracing.tracer": "horizon", "tracing.diffraction": "none"})
    return sr.retrieve(sr.simulate(scene).echoes, scene.resolved_retrieval)["polar"].to_dataset()


def dark(turn: xr.Dataset) -> xr.Dataset:
    """A turn on which nothing was seen."""
    return turn.assign({name: xr.full_like(turn[name], np.nan) for name in SHOWN})


def spread(field: WaveField, polar: xr.Dataset) -> float:
    """m, stated error in the middle of what is looked at, now."""
    azimuth, away = np.radians(float(polar["azimuth"].mean())), float(polar["range"].mean())
    return float(field.elevation(away * np.sin(azimuth), away * np.cos(azimuth), field.issued)[1])


def test_nothing_is_forecast_before_a_sea_is_seen(polar: xr.Dataset) -> None:
    predictor = Predictor()
    assert predictor.turn(dark(polar.isel(turn=0))) is None
    field = predictor.turn(polar.isel(turn=1))
    assert field is not None
    assert field.turns == 1


def after(predictor: Predictor, turns: list[xr.Dataset]) -> WaveField:
    """The field after some turns, of which the last is known to give one."""
    fields = [predictor.turn(turn) for turn in turns]
    assert fields[-1] is not None
    return fields[-1]


def test_a_dark_turn_moves_the_time_on_and_knows_less(polar: xr.Dataset) -> None:
    turns = [polar.isel(turn=number) for number in range(TURNS)]
    whole = after(Predictor(), turns)
    part = after(Predictor(), [*turns[:3], *(dark(turn) for turn in turns[3:])])
    assert part.issued == whole.issued == float(polar["time"].isel(turn=-1).max())
    assert (whole.turns, part.turns) == (TURNS, 3)
    # Of the fit alone: what is wrong of the model is what few turns told of it, more or less by their luck.
    few, many = (replace(each, model_error=ModelError()) for each in (part, whole))
    assert spread(few, polar) > 1.2 * spread(many, polar)


def test_turns_that_are_too_old_are_dropped(polar: xr.Dataset) -> None:
    predictor = Predictor(turns=3)
    assert after(predictor, [polar.isel(turn=number) for number in range(TURNS)]).turns == 3
    late = polar.isel(turn=0)
    late = late.assign_coords(turn=40).assign(time=late["time"] + 40.0)
    assert after(predictor, [late]).turns == 1
    # Long after, in the dark, nothing is told rather than what was long ago.
    later = dark(late.assign_coords(turn=80).assign(time=late["time"] + 40.0))
    assert predictor.turn(later) is None


@pytest.mark.slow
def test_a_current_that_was_told_wrong_is_put_right(polar: xr.Dataset) -> None:
    # The water is at rest. A sector that looks up-wave for seven seconds tells that to 0.2 m/s, and the dark forgets
    # nothing of it.
    told = polar.assign_attrs(current_m_s=(0.6, 0.0))
    turns = [told.isel(turn=number) for number in range(TURNS)]
    current = after(Predictor(), [*turns[:-1], dark(turns[-1])]).spectrum.water.current
    np.testing.assert_allclose(current, (0.0, 0.0), atol=0.2)


def test_another_instrument_tells_more(polar: xr.Dataset) -> None:
    predictor, kind = Predictor(), np.array(["elevation"])
    nought, one = np.zeros(1), np.ones(1)
    with pytest.raises(ValueError, match="no turn has shown a sea"):
        predictor.add_observations(Observations(nought, nought, nought, nought, one, kind))
    field = after(predictor, [polar.isel(turn=number) for number in range(3)])
    time, zero = np.linspace(field.issued - 3.0, field.issued, 30), np.zeros(30)
    more = predictor.add_observations(Observations(zero, zero, time, zero, np.array([0.01]), kind))
    assert np.abs(more.elevation(0.0, 0.0, time[-1])[0]) < 0.3 * field.sea_std
    assert more.issued == field.issued


def test_pairs_are_abreast_and_two_looks_apart() -> None:
    azimuth, away = np.meshgrid(np.radians(np.arange(0.0, 20.0, 2.0)), np.arange(20.0, 60.0, 2.0))
    time = np.degrees(azimuth) / 360.0
    zero, one = np.zeros(azimuth.size), np.ones(azimuth.size)
    kind = np.array(["elevation"])
    seen = Observations(
        (away * np.sin(azimuth)).ravel(), (away * np.cos(azimuth)).ravel(), time.ravel(), zero, one, kind
    )
    pairs = pairs_of_looks(seen, (0.0, 0.0), 50.0)
    distance = away.ravel()
    assert len(pairs) == np.sum(distance[distance < 50.0] > 0.0) // 10 * 8
    np.testing.assert_allclose(np.abs(np.subtract(*time.ravel()[pairs.T])), 4.0 / 360.0)
    np.testing.assert_allclose(distance[pairs[:, 0]], distance[pairs[:, 1]])
