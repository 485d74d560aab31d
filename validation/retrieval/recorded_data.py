"""A recording of a real radar, step by step, to maps: the example to follow.

    python -m validation.retrieval.recorded_data [--out FOLDER]

There is no real recording here, so the scene `tiny` is simulated and written as a foreign recorder might: time factor
exp(−jωt), 16-bit I and Q, ranges 12.3 m long by cables and trigger, an encoder of 8192 counts that counts against the
clock from the bow of a boat that heads 100°, and array names of its own. The steps for any
recording:

1. Which receiver is the lower one, and which array holds it? (`names`)
2. Do phases fall as a target recedes, as conventions.py has it? If they grow: `conjugate = true`.
3. Which range has the first gate, and what do cables and trigger add? (`first_gate_m`, `gate_m`, `range_offset_m`)
4. What does the encoder count, from where and in which direction? (`encoder_counts`, `encoder_zero_deg`,
   `encoder_clockwise`, `azimuth_from`)
5. How do the antennas stand? (`height_m`, `baseline_m`, `tilt_deg`; of a boat that moves `attitude` and `position`)
6. Which antenna sends? (`transmit`; the array `transmitter`)
7. `open_recording(file, header, names)` gives echoes, `retrieve(echoes)` maps.
8. Look at the heights: with the wrong sign of the phase, or antennas exchanged, they are not those of a sea; this
   prints both.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import xarray as xr

import seamap_rt as sr
from seamap_rt.dataset import QUALITY_FLAGS
from seamap_rt.interferometry.recorded import open_recording
from seamap_rt.settings import RetrievalSettings

from ..options import options

HEADING_DEG = 100.0
COUNTS = 8192
CABLE_M = 12.3
FULL_SCALE = 20_000  # counts of the strongest I or Q: an amplifier is set to leave some room
NAMES = {"lower": "rx/1", "upper": "rx/0", "time": "gps/time", "azimuth": "encoder", "transmitter": "tx"}
HEADER = """\
frequency_hz = 10e9
pulse_width_s = 20e-9
bandwidth_hz = 50e6
height_m = 5.0
baseline_m = 0.2
azimuth_beamwidth_deg = {beam}
elevation_beamwidth_deg = 18.0
transmit = "switched"
first_gate_m = {first}
gate_m = 1.5
range_offset_m = {cable}
sector_deg = [240.0, 300.0]
heading_deg = {heading}
azimuth_from = "bow"
encoder_counts = {counts}
encoder_clockwise = false
conjugate = {conjugate}
voltage_scale = {scale}
"""


@dataclass(frozen=True)
class Agreement:
    """Of the maps from a recording with those from the echoes that it was made of."""

    same_cells: float  # share of cells that are known, or unknown, in both
    rms_m: float  # difference of their heights
    largest_m: float
    height_std_m: float  # median error bar, for comparison
    noise_db: float  # of the estimated noise over the true one


def write_recording(echoes: xr.Dataset, folder: Path, conjugate: bool = True) -> tuple[Path, Path]:
    """The recorder's file and its header."""
    voltage = echoes["voltage"].values.conj()
    unit = float(np.abs(voltage.view(np.float32)).max()) / FULL_SCALE
    counts = np.rint(np.stack((np.real(voltage), np.imag(voltage)), axis=-1) / unit).astype(np.int16)
    bow = (HEADING_DEG - echoes["azimuth"].values) / 360.0 * COUNTS
    file, header = folder / "night.h5", folder / f"night-{'conjugate' if conjugate else 'as-it-is'}.toml"
    with h5py.File(file, "w") as recording:
        recording["rx/0"], recording["rx/1"] = counts[:, 1], counts[:, 0]
        recording["gps/time"] = 1.7e9 + echoes["time"].values
        recording["encoder"] = np.floor(bow + 0.5).astype(np.int32) % COUNTS
        recording["tx"] = echoes["transmitter"].values
    text = HEADER.format(
        beam=echoes.attrs["azimuth_beamwidth_deg"],
        first=float(echoes["range"][0]) + CABLE_M,
        cable=CABLE_M,
        heading=HEADING_DEG,
        counts=COUNTS,
        conjugate=str(conjugate).lower(),
        scale=unit,
    )
    header.write_text(text)
    return file, header


def agreement(echoes: xr.Dataset, recorded: xr.Dataset, **settings: Any) -> Agreement:
    """How the maps of both agree. settings: of the retrieval."""
    given = RetrievalSettings.model_validate(settings)
    one, other = (sr.retrieve(each, given)["polar"].to_dataset() for each in (echoes, recorded))
    heights = [each["height"].values for each in (one, other)]
    known = [np.isfinite(each) for each in heights]
    both = known[0] & known[1]
    for each in (one, other):
        both &= (each["quality"].values & (QUALITY_FLAGS["low_coherence"] | QUALITY_FLAGS["ambiguous"])) == 0
    difference = (heights[1] - heights[0])[both]
    return Agreement(
        float(np.mean(known[0] == known[1])),
        float(np.sqrt(np.mean(difference**2))),
        float(np.abs(difference).max()),
        float(np.median(one["height_std"].values[both])),
        float(10.0 * np.log10(recorded.attrs["noise_power_w"] / echoes.attrs["noise_power_w"])),
    )


def main() -> None:
    folder = options(__doc__, out=Path).out
    echoes = sr.simulate(sr.load_scene("tiny")).echoes
    with tempfile.TemporaryDirectory() as temporary:
        folder = folder or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for conjugate in (True, False):
            file, header = write_recording(echoes, folder, conjugate)
            recorded = open_recording(file, header, names=NAMES)
            estimate = agreement(echoes, recorded)
            print(f"{file.name} with conjugate = {str(conjugate).lower()}:")
            print(f"  cells known alike {100.0 * estimate.same_cells:.1f} %, noise {estimate.noise_db:+.2f} dB off")
            print(f"  heights differ by {estimate.rms_m:.4f} m rms, {estimate.largest_m:.3f} m at most", end="; ")
            print(f"their own error bar is {estimate.height_std_m:.3f} m")


if __name__ == "__main__":
    main()
