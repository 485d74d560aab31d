"""Error bars of maps from boats whose motion sensors err: rough_ride, and sensors, boats and seas drawn at random.

    python -m validation.retrieval.sensors --draw N [--count 12] [--seeds 3]

One turn each, 50–200 m, unflagged cells: 1.4826 MAD of error over stated error, the share of errors within 1.96, rms
error and stated error; Hs by `sea_state` with its error bar, and that of these cells' true heights. A constant error is
drawn from the accuracy that is stated: single turns scatter, since a turn has few independent errors of tilt.
"""

from __future__ import annotations

import numpy as np

import seamap_rt as sr
from seamap_rt.scene import Scene
from seamap_rt.simulation import Simulator

from ..draws import Keys, mast, waves
from ..options import options
from .seas import against_truth


def ridden(number: int, place: int) -> Scene:
    """A boat that rolls or rides the waves; sensors of 0 to 0.5° and 0 to 0.1 m of noise at 5 to 100 Hz."""
    stream = np.random.default_rng([number, 99, place])
    while True:
        keys: Keys = waves(stream, (0.3, 2.5), (3.5, 9.0)) | mast(stream, 3.0, 12.0) | boat(stream)
        own = {"seed": int(stream.integers(1, 2**31)), "name": f"ridden_{number}_{place}"}
        try:
            return sr.load_scene("choppy_sea", overrides=keys | own)
        except sr.InputError:
            continue


def boat(stream: np.random.Generator) -> Keys:
    """Keys of a boat and its sensors."""
    keys: Keys = {
        "motion": str(stream.choice(["wave_following", "sinusoidal"])),
        "heading_deg": stream.uniform(0.0, 360.0),
    }
    if keys["motion"] == "sinusoidal":
        for name, most in {"roll_deg": 10.0, "pitch_deg": 5.0, "yaw_deg": 5.0, "heave_m": 0.5}.items():
            stem = name.split("_")[0]
            keys |= {name: stream.uniform(0.0, most), f"{stem}_period_s": stream.uniform(3.0, 8.0)}
            keys[f"{stem}_phase_deg"] = stream.uniform(0.0, 360.0)
    keys["speed_m_s"] = stream.uniform(0.0, 4.0)
    sensors = {
        "attitude_noise_deg": stream.uniform(0.0, 0.5),
        "heading_noise_deg": stream.uniform(0.0, 0.5),
        "position_noise_m": stream.uniform(0.0, 0.1),
        "rate_hz": np.exp(stream.uniform(np.log(5.0), np.log(100.0))),
        "latency_s": stream.uniform(0.0, 0.02),
        "attitude_accuracy_deg": stream.uniform(0.0, 0.2),
        "heading_accuracy_deg": stream.uniform(0.0, 1.0),
        "height_accuracy_m": stream.uniform(0.0, 0.1),
    }
    for axis in ("roll", "pitch", "heading", "height"):
        unit = "m" if axis == "height" else "deg"
        accuracy = f"{'attitude' if axis in ('roll', 'pitch') else axis}_accuracy_{unit}"
        sensors[f"{axis}_bias_{unit}"] = sensors[accuracy] * stream.standard_normal()
    both = {f"platform.{name}": value for name, value in keys.items()}
    both |= {f"platform.sensors.{name}": value for name, value in sensors.items()}
    return {name: value if isinstance(value, str) else float(value) for name, value in both.items()}


def found(scene: Scene) -> tuple[str, np.ndarray]:
    """A row of figures, and error over stated error of the cells."""
    turn = Simulator(scene).turn(0)
    maps = sr.retrieve(turn.echoes)
    figures, cells = against_truth(maps, turn.truth)
    got, true = (each["polar"].to_dataset().isel(turn=0) for each in (maps, turn.truth))
    std = got["height_std"].values[cells]
    state = sr.sea_state(maps).isel(turn=0)
    hs, bar = (float(state[f"significant_wave_height{name}"]) for name in ("", "_std"))
    sensors = scene.platform.sensors
    line = (
        f"| {scene.name} {scene.seed} | {scene.platform.motion} | {sensors.attitude_noise_deg:.2f}°, "
        f"{sensors.position_noise_m:.2f} m, {sensors.rate_hz:.0f} Hz | "
        f"{figures['ratio']:.2f} | {100 * figures['within']:.1f} % | "
        f"{figures['rms']:.3f}, {np.sqrt(np.mean(std**2)):.3f} | {hs:.2f} ± {bar:.2f}, {figures['hs']:.2f} |"
    )
    return line, (got["height"].values - true["height"].values)[cells] / std


def main() -> None:
    arguments = options(__doc__, draw=500, count=12, seeds=3)
    rides = [
        sr.load_scene("rough_ride", overrides={"seed": seed, "tracing.tracer": "horizon"})
        for seed in range(1, 1 + arguments.seeds)
    ]
    drawn = [ridden(arguments.draw, place) for place in range(arguments.count)]
    print("**errors over stated ones, 50–200 m**\n")
    print("| scene, seed | motion | sensors | ratio | within 1.96 | rms, stated, m | Hs found, true, m |")
    print("|---|---|---|---|---|---|---|")
    for name, scenes in (("rough_ride", rides), ("drawn", drawn)):
        errors = []
        for scene in scenes:
            line, ratios = found(scene)
            errors.append(ratios)
            print(line, flush=True)
        if errors:
            every = np.concatenate(errors)
            ratio = 1.4826 * np.median(np.abs(every - np.median(every)))
            within = f"{100 * np.mean(np.abs(every) < 1.96):.1f} %"
            print(f"| {name}, together | | | {ratio:.2f} | {within} | | |", flush=True)


if __name__ == "__main__":
    main()
