"""Scenes that nobody chose: seas, radars and masts drawn at random from one number that is asked for when a judge runs.

    python -m validation.draws 7 --of seas --count 40

prints what a number draws. Each judge that takes `--draw N` reports on these scenes, so that a number that nobody has
used yet is a sea that nothing was tuned on.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

import numpy as np

import seamap_rt as sr
from seamap_rt.scene import Scene

Keys = dict[str, Any]

_G = 9.81  # m/s²
_STEEPEST = 1.0 / 18.0  # Hs over the peak's deep-water wavelength: a young wind sea
_SHALLOWEST = 0.4  # Hs over depth: higher waves break
_PATCH_M, _LARGE_PATCH_M = 1024.0, 2048.0  # the sea repeats beyond
_LONG_S = 8.0  # peak period from which on the larger patch is taken


def waves(
    stream: np.random.Generator,
    height_m: tuple[float, float] = (0.3, 5.0),
    period_s: tuple[float, float] = (3.0, 16.0),
    systems: int | None = None,
) -> Keys:
    """Keys of a sea of one to three JONSWAP systems and the wind over it: longest system's Hs and Tp within limits.

    Heights are drawn evenly in their logarithm, periods evenly; a system is no steeper than 1/18. The wind is that
    which raises the shortest system's height when fully developed, H = 0.21 U²/g, from within 30° of its direction.
    """
    count = int(stream.integers(1, 4)) if systems is None else systems
    longest = float(stream.uniform(*period_s))
    periods = [longest]
    for _ in range(count - 1):
        periods.append(float(stream.uniform(0.35, 0.75)) * periods[-1])
    periods = [each for each in periods if each >= 3.0] or [max(longest, 3.0)]
    systems_: list[Keys] = []
    for period in periods:
        most = min(height_m[1], _STEEPEST * _G * period**2 / (2.0 * np.pi))
        least = min(height_m[0], 0.9 * most)
        swell = period > 9.0
        systems_.append(
            {
                "spectrum": "jonswap",
                "significant_wave_height_m": float(np.exp(stream.uniform(np.log(least), np.log(most)))),
                "peak_period_s": period,
                "peak_enhancement": float(stream.uniform(1.0, 5.0)),
                "wave_from_deg": float(stream.uniform(0.0, 360.0)),
                "spreading": "cos2s",
                "spreading_exponent": float(stream.uniform(20.0, 70.0) if swell else stream.uniform(5.0, 20.0)),
            }
        )
    wind = np.sqrt(systems_[-1]["significant_wave_height_m"] * _G / 0.21)
    return {
        "sea.waves": systems_,
        "sea.extent_m": _LARGE_PATCH_M if longest > _LONG_S else _PATCH_M,
        "scattering.wind_speed_m_s": float(np.clip(wind, 4.0, 13.0)),
        "scattering.wind_from_deg": float(systems_[-1]["wave_from_deg"] + stream.uniform(-30.0, 30.0)) % 360.0,
        "scattering.polarization": str(stream.choice(["VV", "HH"])),
    }


def water(stream: np.random.Generator, highest_m: float) -> Keys:
    """Keys of the depth (4 m to 60 m in one of two, else deep) and of a current of up to 1.5 m/s in one of two."""
    depth = float(np.exp(stream.uniform(np.log(4.0), np.log(60.0)))) if stream.random() < 0.5 else np.inf
    speed = float(stream.uniform(0.0, 1.5)) if stream.random() < 0.5 else 0.0
    return {
        "sea.depth_m": max(depth, highest_m / _SHALLOWEST),
        "sea.current_m_s": speed,
        "sea.current_toward_deg": float(stream.uniform(0.0, 360.0)),
    }


def mast(stream: np.random.Generator, lowest_m: float = 2.2, highest_m: float = 25.0) -> Keys:
    """Keys of a mast (evenly in the logarithm of its height), its baseline of 3 to 6 % of that, and the range."""
    height = float(np.exp(stream.uniform(np.log(lowest_m), np.log(highest_m))))
    return {
        "radar.height_m": height,
        "radar.baseline_m": float(np.clip(stream.uniform(0.03, 0.06) * height, 0.1, 1.0)),
        "radar.range_m": [max(15.0, height + 5.0), 210.0],
        "tracing.tracer": "horizon",
    }


def radar(stream: np.random.Generator) -> Keys:
    """Keys of another X-band radar: carrier, rate, pulse, power, beam, turn, as small boats carry."""
    pulse = float(stream.uniform(15e-9, 40e-9))
    beam = float(stream.uniform(1.0, 2.4))
    return {
        "radar.frequency_hz": float(stream.uniform(9.3e9, 9.5e9)),
        "radar.prf_hz": float(np.exp(stream.uniform(np.log(2500.0), np.log(12000.0)))),
        "radar.pulse_width_s": pulse,
        "radar.bandwidth_hz": 1.0 / pulse,
        "radar.transmit_power_w": float(np.exp(stream.uniform(np.log(0.5), np.log(25.0)))),
        "radar.rotation_rpm": float(stream.uniform(24.0, 60.0)),
        "radar.antenna.azimuth_beamwidth_deg": beam,
        "radar.antenna.width_m": 1.8 / beam,
        "radar.antenna.elevation_beamwidth_deg": float(stream.uniform(15.0, 25.0)),
        "radar.transmit": str(stream.choice(["switched", "single"])),
    }


def sea_of_any_kind(stream: np.random.Generator) -> Keys:
    """Hs 0.3–5 m, Tp 3–16 s, one to three systems, 4 m of water to deep, current to 1.5 m/s, masts of 2.2–25 m."""
    keys = waves(stream)
    highest = float(np.hypot.reduce([each["significant_wave_height_m"] for each in keys["sea.waves"]]))
    return keys | water(stream, highest) | mast(stream)


def long_swell(stream: np.random.Generator) -> Keys:
    """One system of Tp 9–15 s, longer than the circle in sight from masts of 4–9 m."""
    return waves(stream, (0.8, 4.0), (9.0, 15.0), systems=1) | mast(stream, 4.0, 9.0)


def crossing(stream: np.random.Generator) -> Keys:
    """A swell of 9–14 s and a wind sea of 3.5–6 s from at least 45° aside, from masts of 4–9 m."""
    swell = waves(stream, (0.8, 2.5), (9.0, 14.0), systems=1)
    wind = waves(stream, (0.4, 1.5), (3.5, 6.0), systems=1)
    aside = float(stream.uniform(45.0, 180.0) * stream.choice([-1.0, 1.0]))
    swell["sea.waves"][0]["wave_from_deg"] = (wind["sea.waves"][0]["wave_from_deg"] + aside) % 360.0
    return (
        wind
        | {"sea.waves": swell["sea.waves"] + wind["sea.waves"], "sea.extent_m": _LARGE_PATCH_M}
        | mast(stream, 4.0, 9.0)
    )


def radar_of_any_kind(stream: np.random.Generator) -> Keys:
    """Another radar on any mast over any sea in deep water."""
    return waves(stream) | mast(stream, 3.0, 20.0) | radar(stream)


KINDS: dict[str, Callable[[np.random.Generator], Keys]] = {
    "seas": sea_of_any_kind,
    "long": long_swell,
    "crossing": crossing,
    "radars": radar_of_any_kind,
}


def drawn(number: int, kind: str, count: int, **more: Any) -> list[Scene]:
    """`count` scenes of one of KINDS; more: overrides of keys, with `__` for a dot. Each depends on its place alone.

    Scenes that the checks refuse (too steep a wave for the wind's model, a pulse rate too low for the range) are drawn
    again from the same stream.
    """
    extra = {name.replace("__", "."): value for name, value in more.items()}
    made: list[Scene] = []
    for n in range(count):
        stream = np.random.default_rng([number, sorted(KINDS).index(kind), n])
        while len(made) == n:
            own = {"seed": int(stream.integers(1, 2**31)), "name": f"{kind}_{number}_{n}"}
            try:
                made.append(sr.load_scene("choppy_sea", overrides=KINDS[kind](stream) | own | extra))
            except sr.InputError:
                continue
    return made


def in_words(scene: Scene) -> str:
    """One line: systems, water, mast, radar."""
    systems = ", ".join(
        f"{each.significant_wave_height_m:.2f} m {each.peak_period_s:.1f} s {each.wave_from_deg:.0f}°"  # type: ignore[union-attr]
        for each in scene.sea.waves
    )
    antenna = scene.radar
    return (
        f"{systems}; depth {scene.sea.depth_m:.3g} m, current {scene.sea.current_m_s:.1f} m/s; "
        f"mast {antenna.height_m:.1f} m, B {antenna.baseline_m:.2f} m, {scene.scattering.polarization}, "
        f"{antenna.transmit}, {antenna.rotation_rpm:.0f} rpm, {antenna.transmit_power_w:.1f} W, {antenna.prf_hz:.0f} Hz"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("number", type=int)
    parser.add_argument("--of", choices=list(KINDS), default="seas")
    parser.add_argument("--count", type=int, default=12)
    arguments = parser.parse_args()
    for scene in drawn(arguments.number, arguments.of, arguments.count):
        print(f"{scene.name:16} {in_words(scene)}")


if __name__ == "__main__":
    main()
