"""A recording of the scene `tiny`, spoilt as recorders and headers spoil it: what is refused, what said, what passes.

    python -m validation.retrieval.spoilt [--only WORD]

A line a case: the refusal, or what the inspection calls wrong or doubtful, gravest first, and the wave height
that would be believed without it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import seamap_rt as sr

from ..options import options

HEADER: dict[str, Any] = {
    "frequency_hz": 10e9,
    "pulse_width_s": 20e-9,
    "bandwidth_hz": 50e6,
    "height_m": 5.0,
    "baseline_m": 0.2,
    "azimuth_beamwidth_deg": 1.8,
    "elevation_beamwidth_deg": 18.0,
    "transmit": "switched",
    "first_gate_m": 15.0,
    "gate_m": 1.5,
    "sector_deg": [240.0, 300.0],
}
Case = dict[str, Any]


def cases() -> dict[str, Case]:
    """What is spoilt → what differs from the recording as it should be."""
    scene = sr.load_scene("tiny", overrides={"turns": 2, "tracing.tracer": "horizon", "seed": 5})
    echoes = sr.simulate(scene).echoes
    lower, upper = (np.ascontiguousarray(echoes["voltage"].values[:, each]) for each in (0, 1))
    time, azimuth, transmitter = (echoes[name].values for name in ("time", "azimuth", "transmitter"))
    right: Case = {"lower": lower, "upper": upper, "time": time, "azimuth": azimuth, "transmitter": transmitter}
    pulses = time.size
    generator = np.random.default_rng(0)
    few = generator.random(pulses) < 0.1
    gap = ~((np.arange(pulses) >= 300) & (np.arange(pulses) < 700))
    level = np.abs(lower).mean()
    swung = time.copy()
    swung[pulses // 4 : pulses // 4 + 50] = swung[pulses // 4 : pulses // 4 + 50][::-1]
    jumped = azimuth.copy()
    jumped[pulses // 4 : pulses // 4 + 200] += 15.0

    def clipped(voltage: np.ndarray) -> np.ndarray:
        return np.clip(np.real(voltage), -2e-6, 2e-6) + 1j * np.clip(np.imag(voltage), -2e-6, 2e-6)

    spoilt: dict[str, Case] = {
        "nothing": {},
        "receivers exchanged": {"lower": upper, "upper": lower},
        "both conjugated": {"lower": lower.conj(), "upper": upper.conj()},
        "one conjugated": {"upper": upper.conj()},
        "the same twice": {"upper": lower},
        "upper silent": {"upper": 0.0 * upper},
        "both silent": {"lower": 0.0 * lower, "upper": 0.0 * upper},
        "real parts alone": {"lower": np.real(lower) + 0j, "upper": np.real(upper) + 0j},
        "I and Q exchanged": {"lower": 1j * lower.conj(), "upper": 1j * upper.conj()},
        "a constant added": {"lower": lower + 3.0 * level, "upper": upper + 3.0 * level},
        "clipped": {"lower": clipped(lower), "upper": clipped(upper)},
        "phase 90° off": {"upper": 1j * upper},
        "phase 180° off": {"upper": -upper},
        "upper a pulse late": {"upper": np.roll(upper, 1, axis=0)},
        "upper a gate late": {"upper": np.roll(upper, 1, axis=1)},
        "upper two gates late": {"upper": np.roll(upper, 2, axis=1)},
        "transmitters exchanged": {"transmitter": 1 - transmitter},
        "10 % of pulses NaN": {"lower": np.where(few[:, None], np.nan, lower)},
        "10 % of azimuths NaN": {"azimuth": np.where(few, np.nan, azimuth)},
        "all azimuths NaN": {"azimuth": np.full(pulses, np.nan)},
        "azimuth in radians": {"azimuth": np.radians(azimuth)},
        "azimuth the other way": {"azimuth": 540.0 - azimuth},
        "azimuth jumps": {"azimuth": jumped},
        "azimuth stands": {"azimuth": np.full(pulses, 270.0)},
        "time in ms": {"time": 1e3 * time},
        "time in µs": {"time": 1e6 * time},
        "time runs back": {"time": swung},
        "time rounded": {"time": np.round(time, 2)},
        "10 % of pulses lost": {name: array[~few] for name, array in right.items()},
        "400 pulses lost": {name: array[gap] for name, array in right.items()},
        "gates 3 m": {"gate_m": 3.0},
        "gates 0.75 m": {"gate_m": 0.75},
        "first gate 30 m": {"first_gate_m": 30.0},
        "first gate 0 m": {"first_gate_m": 0.0},
        "mast 3 m": {"height_m": 3.0},
        "mast 8 m": {"height_m": 8.0},
        "mast 50 m": {"height_m": 50.0},
        "baseline 0.1 m": {"baseline_m": 0.1},
        "baseline 0.4 m": {"baseline_m": 0.4},
        "5 GHz": {"frequency_hz": 5e9},
        "9.4 GHz": {"frequency_hz": 9.4e9},
        "9.4 (in GHz)": {"frequency_hz": 9.4},
    }
    return {name: right | change for name, change in spoilt.items()}


def said(case: Case) -> str:
    """What the program says of one case."""
    header = HEADER | {name: case[name] for name in HEADER if name in case}
    arrays = {name: case[name] for name in ("time", "azimuth", "transmitter")}
    try:
        echoes = sr.echoes_from_recording(case["lower"], case["upper"], header, **arrays)
        maps = sr.retrieve(echoes)
    except sr.InputError as error:
        return f"refused: {error}"
    grave = [each for each in sr.inspect(echoes, maps) if each.verdict in ("wrong", "doubtful")]
    height = float(sr.sea_state(maps)["significant_wave_height"].values.ravel()[0])
    words = " | ".join(f"{each.verdict}: {each.line}" for each in grave)
    return f"{words or 'nothing'} (Hs {height:.2f} m)"


def main() -> None:
    given = options(__doc__, only="")
    for name, case in cases().items():
        if given.only in name:
            print(f"{name:24} {said(case)}", flush=True)


if __name__ == "__main__":
    main()
