"""What the boat's motion does to the heights, with perfect sensors and with faulty ones.

    python -m validation.radar.riding [--seeds 3] [--scene choppy_sea] [--parts motion,roll,sensors]

 motion   a boat with list or trim, that swings or that follows the waves, sensors perfect: errors from 50 to 200 m,
          beside those of the boat at rest, without noise and with it
 roll     a roll sensor 0.1° off: mean height error abeam, beside R δα
 sensors  biased, late, noisy and infrequent readings on a boat that swings

The predicted error with noise is the boat's own without noise and, added in square, the error by noise of the boat at
rest, enlarged because an elevation beam that points up and down weakens the echo. All sensors are compared on the same
echoes: they change what the retrieval is given, not where the antenna was.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.conventions import db, unit_from_azimuth
from seamap_rt.radar.antenna import antenna
from seamap_rt.radar.installation import Installation
from seamap_rt.resolved_scene import installation_of
from seamap_rt.scene import Scene
from seamap_rt.simulation import Simulator, Turn

from ..options import options
from .modes import Cells, rms, spread, with_noise

PARTS = ("motion", "roll", "sensors")
HEADLINE_M = (50.0, 200.0)
FAITHFUL_DB = 0.0  # SNR below which a cell has no echo: retrieval.min_snr_db

REST: dict[str, Any] = {}
SWINGING: dict[str, Any] = {"motion": "sinusoidal", "roll_deg": 10.0, "pitch_deg": 5.0, "heave_m": 0.5}
FOLLOWING: dict[str, Any] = {"motion": "wave_following", "speed_m_s": 3.0, "length_m": 7.0}
MOTIONS: dict[str, dict[str, Any]] = {
    "at rest": REST,
    "list 10°": {"list_deg": 10.0},
    "trim 5°": {"trim_deg": 5.0},
    "swinging 10°, 5°, 0.5 m": SWINGING,
    "follows waves, heading 0°": FOLLOWING,
    "follows waves, heading 90°": {**FOLLOWING, "heading_deg": 90.0},
    "follows waves, heading 270°": {**FOLLOWING, "heading_deg": 270.0},
}
ROLL_BIAS_DEG = 0.1
SENSORS: dict[str, dict[str, float]] = {
    "perfect": {},
    "roll 0.1° off": {"roll_bias_deg": 0.1},
    "heading 1° off": {"heading_bias_deg": 1.0},
    "height 0.1 m off": {"height_bias_m": 0.1},
    "10 readings a second": {"rate_hz": 10.0},
    "50 ms late": {"latency_s": 0.05},
    "5 ms late": {"latency_s": 0.005},
    "0.05° rms every pulse": {"attitude_noise_deg": 0.05},
    "0.05° rms, 10 a second": {"attitude_noise_deg": 0.05, "rate_hz": 10.0},
}


def boat_scene(scene: str, seed: int, platform: dict[str, Any], **keys: Any) -> Scene:
    """The scene without noise, from a boat with that motion; retrieved with one window for all, by p = 1 alone."""
    settings = {"seed": seed, "radar.noise": False, "tracing.tracer": "horizon", "radar.range_m": [15.0, 210.0]}
    settings |= {"retrieval.estimator": "sliding_plane", "retrieval.paths": "one_way"}
    boat = {f"platform.{key}": value for key, value in platform.items()}
    return sr.load_scene(scene, overrides={**settings, **boat, **keys})


def as_sensed(echoes: xr.Dataset, made: Scene, sensors: dict[str, float]) -> xr.Dataset:
    """The same echoes with the readings of other sensors."""
    settings = made.platform.sensors.model_copy(update=sensors)
    boat = made.model_copy(update={"platform": made.platform.model_copy(update={"sensors": settings})})
    pose = installation_of(boat).sensed.pose(echoes["time"].values)
    said = {"position": pose.positions, "attitude": pose.attitude, "azimuth": pose.bearing}
    return echoes.assign({name: echoes[name].copy(data=values) for name, values in said.items()})


# -------------------------------------------------------------------------------------------- motion


@dataclass(frozen=True)
class Ride:
    """A turn of one boat on one sea: cells without noise and with it, and its elevation beam's two-way gain there."""

    clean: Cells
    noisy: Cells
    beam: NDArray[np.float64]  # (look, gate), 1 on the boresight

    @classmethod
    def of(cls, made: Scene) -> Ride:
        simulator = Simulator(made)
        turn = simulator.turn(0)
        loud = with_noise(turn, made.radar, made.seed, simulator.installation)
        return cls(seen(turn, made), seen(loud, made), elevation_gain(turn, made, simulator.installation))


def seen(turn: Turn, made: Scene) -> Cells:
    return Cells.between(sr.retrieve(turn.echoes, made.retrieval), turn.truth, made.radar)


def elevation_gain(turn: Turn, made: Scene, mast: Installation) -> NDArray[np.float64]:
    """(look, gate) two-way power gain towards mean sea level, off the boresight's, as the array stands at each look."""
    true = turn.truth["polar"].to_dataset().isel(turn=0)
    pose = mast.pose(true["time"].values)
    east, north = unit_from_azimuth(true["azimuth"].values)
    sine = -pose.origin[:, 2, None] / true["range"].values
    level = np.sqrt(1.0 - sine**2)
    up = pose.axes[:, 2]
    along = (up[:, 0] * east + up[:, 1] * north)[:, None] * level + up[:, 2, None] * sine
    return antenna(made.radar).elevation(along) ** 4


def noise_law(rest: Ride) -> float:
    """The number of samples 2N of var φ = (2/S + 1/S²)/(2N) that noise showed from the boat at rest."""
    inside = rest.clean.within(*HEADLINE_M) & rest.noisy.within(*HEADLINE_M)
    added = ((rest.noisy.height - rest.clean.height) * rest.clean.radians_per_m)[inside]
    noise = 10.0 ** (-0.1 * rest.noisy.snr_db[inside])
    return float(np.mean(2.0 * noise + noise**2) / np.mean(added**2))


def predicted_rmse(ride: Ride, rest: Ride) -> float:
    """Height rmse with noise, from the boat's own without it and the resting boat's SNR, changed by the beam."""
    snr_db = rest.noisy.snr_db + db(ride.beam / rest.beam)
    inside = ride.clean.within(*HEADLINE_M) & (snr_db >= FAITHFUL_DB)
    noise = 10.0 ** (-0.1 * snr_db[inside])
    added = (2.0 * noise + noise**2) / noise_law(rest) / ride.clean.radians_per_m[inside] ** 2
    return float(np.sqrt(np.mean(ride.clean.error[inside] ** 2) + np.mean(added)))


def error(cells: Cells, where: NDArray[np.bool_] | bool = True) -> float:
    return rms(cells.error[cells.within(*HEADLINE_M) & where])


def print_motion(scene: str, seeds: int) -> None:
    rides = {
        name: [Ride.of(boat_scene(scene, seed, platform)) for seed in range(1, seeds + 1)]
        for name, platform in MOTIONS.items()
    }
    print("\nHeight rmse, 50–200 m, m, and its ratio to the boat at rest; sensors perfect; ± over seeds")
    groups = f"{'without noise':^43} {'with noise':^50}"
    heading = ("rmse", "ratio", "bias", "rmse", "ratio", "predicted", "cells/at rest")
    print(f"{'':28} {groups}\n{'boat':28} " + " ".join(f"{name:>14}" for name in heading))
    rest = rides["at rest"]
    for name, boats in rides.items():
        each = list(zip(boats, rest, strict=True))
        shown = (
            spread(error(b.clean) for b in boats),
            spread(error(b.clean) / error(r.clean) for b, r in each),
            spread(b.clean.error[b.clean.within(*HEADLINE_M)].mean() for b in boats),
            spread(error(b.noisy) for b in boats),
            spread(error(b.noisy) / error(r.noisy) for b, r in each),
            spread(predicted_rmse(b, r) / predicted_rmse(r, r) for b, r in each),
            spread(b.noisy.within(*HEADLINE_M).sum() / r.noisy.within(*HEADLINE_M).sum() for b, r in each),
        )
        print(f"{name:28} " + " ".join(f"{value:>14}" for value in shown), flush=True)
    print_quarters(rides)


def print_quarters(rides: dict[str, list[Ride]]) -> None:
    """Where the beam's fan leans, a point off its middle reads too high or too low."""
    print("\nThe same without noise by quarters of the compass: ratio to the boat at rest")
    quarters = {"north": 0.0, "east": 90.0, "south": 180.0, "west": 270.0}
    print(f"{'boat':28} " + " ".join(f"{name:>14}" for name in quarters))
    for name, boats in rides.items():
        shown = []
        for middle in quarters.values():
            ratios = [
                error(b.clean, near(b.clean, middle, 45.0)) / error(r.clean, near(r.clean, middle, 45.0))
                for b, r in zip(boats, rides["at rest"], strict=True)
            ]
            shown.append(f"{spread(ratios):>14}")
        print(f"{name:28} " + " ".join(shown))


def near(cells: Cells, azimuth_deg: float, within_deg: float) -> NDArray[np.bool_]:
    return np.cos(np.radians(cells.azimuth - azimuth_deg)) > np.cos(np.radians(within_deg))


# -------------------------------------------------------------------------------------------- roll


def roll_bias(turn: Turn, made: Scene, bias_deg: float) -> Iterator[tuple[str, float, float, float]]:
    """Side, range, mean height error that the bias adds and −R δα sin(off the bow), the prediction."""
    fault = as_sensed(turn.echoes, made, {"roll_bias_deg": bias_deg})
    clean, off = (
        Cells.between(sr.retrieve(echoes, made.retrieval), turn.truth, made.radar) for echoes in (turn.echoes, fault)
    )
    bow = made.platform.heading_deg
    for side, abeam in (("starboard", 90.0), ("port", 270.0)):
        for distance in (50.0, 100.0, 200.0):
            inside = clean.within(0.9 * distance, 1.1 * distance) & np.isfinite(off.height)
            inside &= near(clean, bow + abeam, 10.0)
            if not inside.any():  # a sector need not look there
                continue
            predicted = -clean.range * np.radians(bias_deg) * np.sin(np.radians(clean.azimuth - bow))
            yield side, distance, float((off.height - clean.height)[inside].mean()), float(predicted[inside].mean())


def print_roll(scene: str, seeds: int) -> None:
    print(f"\nA roll sensor that says {ROLL_BIAS_DEG:g}° too much, boat at rest: what that adds to the mean height, m")
    rows: dict[tuple[str, float], list[tuple[float, float]]] = {}
    for seed in range(1, seeds + 1):
        made = boat_scene(scene, seed, REST, **{"radar.range_m": [15.0, 230.0]})
        for side, distance, got, predicted in roll_bias(Simulator(made).turn(0), made, ROLL_BIAS_DEG):
            rows.setdefault((side, distance), []).append((got, predicted))
    print(f"{'side':10} {'R, m':>5} {'measured':>14} {'∓R δα':>8} {'ratio':>7}")
    for (side, distance), values in rows.items():
        got, predicted = np.array(values).T
        print(
            f"{side:10} {distance:5.0f} {spread(got, 4):>14} {predicted.mean():+8.4f} "
            f"{got.mean() / predicted.mean():7.4f}"
        )


# -------------------------------------------------------------------------------------------- sensors


def print_sensors(scene: str, seeds: int) -> None:
    print(f"\nSensors of a boat that swings {SWINGING}: heights, 50–200 m, without noise, m")
    heading = ("rmse", "bias", "of the fault alone", "50–100 m", "150–200 m")
    print(f"{'sensors':28} " + " ".join(f"{name:>18}" for name in heading))
    rows: dict[str, list[tuple[float, ...]]] = {name: [] for name in SENSORS}
    for seed in range(1, seeds + 1):
        made = boat_scene(scene, seed, SWINGING)
        turn = Simulator(made).turn(0)
        perfect = seen(turn, made)
        for name, sensors in SENSORS.items():
            echoes = as_sensed(turn.echoes, made, sensors)
            cells = Cells.between(sr.retrieve(echoes, made.retrieval), turn.truth, made.radar)
            more = cells.height - perfect.height
            alone = [
                rms(more[perfect.within(low, high) & cells.within(low, high)])
                for low, high in (HEADLINE_M, (50.0, 100.0), (150.0, 200.0))
            ]
            rows[name].append((error(cells), cells.error[cells.within(*HEADLINE_M)].mean(), *alone))
    for name, values in rows.items():
        print(f"{name:28} " + " ".join(f"{spread(column):>18}" for column in zip(*values, strict=True)))


def main() -> None:
    arguments = options(__doc__, seeds=3, scene="choppy_sea", parts=",".join(PARTS))
    for part, print_part in zip(PARTS, (print_motion, print_roll, print_sensors), strict=True):
        if part in arguments.parts.split(","):
            print_part(arguments.scene, arguments.seeds)


if __name__ == "__main__":
    main()
