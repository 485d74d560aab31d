"""What a chirp gains and loses: signal to noise and height error by range, beside the plain pulse.

    python -m validation.radar.waveforms [--seeds 3]

A chirp of half a microsecond sees further for the same peak power, but receives nothing while it is sent (nearer than
c T/2, in part), and its sidelobes carry the strong near echo into every gate: the less, the larger pulse width ×
bandwidth is.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

import seamap_rt as sr

from ..options import options

SECTOR_DEG = [240.0, 300.0]  # up the waves
BANDS_M = [50.0, 100.0, 200.0, 300.0, 400.0]
CASES = {
    "pulse, 20 ns": {},
    "chirp, 0.5 µs, Hamming": {"radar.waveform": "chirp", "radar.pulse_width_s": 0.5e-6},
    "chirp, 1 µs, Hamming": {"radar.waveform": "chirp", "radar.pulse_width_s": 1e-6},
    "chirp, 1 µs, Taylor": {
        "radar.waveform": "chirp",
        "radar.pulse_width_s": 1e-6,
        "radar.compression_window": "taylor",
    },
}


def by_band(seed: int, keys: dict[str, object]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Median SNR [dB], rms height error [m] and share of the visible cells that are answered, by band."""
    fixed = {"tracing.tracer": "horizon", "radar.sector_deg": SECTOR_DEG, "seed": seed}
    fixed |= {"retrieval.estimator": "sliding_plane", "retrieval.paths": "one_way"}  # one window for all
    scene = sr.load_scene("choppy_sea", fixed | keys)
    simulation = sr.simulate(scene)
    maps = sr.retrieve(simulation.echoes)["polar"].to_dataset()
    truth = simulation.truth["polar"].to_dataset()
    band = np.digitize(maps["range"].values, BANDS_M) - 1
    visible = truth["visible_fraction"].values[0] > 0.5
    error = maps["height"].values[0] - truth["height"].values[0]
    clear = (maps["quality"].values[0] & 4) == 0
    snr = maps["snr_db"].values[0]
    rows = []
    for number in range(len(BANDS_M) - 1):
        inside = visible & (band == number)
        known = inside & np.isfinite(error) & clear
        rows.append((np.nanmedian(snr[inside]), np.sqrt(np.mean(error[known] ** 2)), known.sum() / inside.sum()))
    columns = np.array(rows).T
    return columns[0], columns[1], columns[2]


def main() -> None:
    arguments = options(__doc__, seeds=3)
    bands = "".join(f"{near:>12g}–{far:g} m" for near, far in pairwise(BANDS_M))
    print(f"choppy_sea, {SECTOR_DEG[0]:g}–{SECTOR_DEG[1]:g}°, 1 W, mean of {arguments.seeds} seeds: SNR/error/answered")
    print(f"{'':24}{bands}")
    for name, keys in CASES.items():
        snr, rms, share = np.mean([by_band(seed, keys) for seed in range(1, arguments.seeds + 1)], axis=0)
        cells = "".join(f"  {s:5.1f} dB {e:.2f} m {a:3.0%}" for s, e, a in zip(snr, rms, share, strict=True))
        print(f"{name:24}{cells}", flush=True)


if __name__ == "__main__":
    main()
