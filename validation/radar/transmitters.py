"""Coherent transmitter or magnetron: what each of the four modes keeps of heights and velocities.

    python -m validation.radar.transmitters [--seeds 3] [--forecast 0]

Heights against the truth, 50–200 m, cells more than half visible and not ambiguous: rms, 1.4826 MAD, the share of
errors within 1.96 stated ones. Velocities against those of a coherent transmitter without noise, of the same sea and
speckle, where echoes stand 10 dB over the noise. Means over the seeds.

--forecast N: heights at the boat, forecast by N turns' maps with and without velocities, as in
validation.prediction.forecasts.
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np
import xarray as xr

import seamap_rt as sr
from seamap_rt.dataset import QUALITY_FLAGS

from ..prediction import forecasts
from ..retrieval.cells import rms, robust
from .modes import MODES, Mode

NEAR_M, FAR_M, STRONG_DB = 50.0, 200.0, 10.0
MEASURED: dict[str, Any] = {"radar.transmitter": "magnetron", "radar.coherent_on_receive": True}
TRANSMITTERS: dict[str, dict[str, Any]] = {
    "coherent": {},
    "magnetron": {"radar.transmitter": "magnetron", "radar.frequency_jitter_hz": 1e5},
    **{f"measured to {error:g}°": {**MEASURED, "radar.transmit_phase_error_deg": error} for error in (3.0, 10.0, 30.0)},
}


def simulated(mode: Mode, seed: int, **keys: Any) -> tuple[xr.Dataset, xr.Dataset]:
    """Polar map and truth of one turn of choppy_sea, by the scene's own retrieval."""
    fixed = {"seed": seed, "tracing.tracer": "horizon", "radar.transmit": mode.transmit}
    scene = sr.load_scene("choppy_sea", {**fixed, "radar.interferogram": mode.interferogram, **keys})
    made = sr.simulate(scene)
    got, true = sr.retrieve(made.echoes, scene.resolved_retrieval), made.truth
    return tuple(tree["polar"].to_dataset().isel(turn=0) for tree in (got, true))  # type: ignore[return-value]


def figures(got: xr.Dataset, true: xr.Dataset, still: xr.Dataset) -> list[float]:
    """Heights' rms and robust error [m], share within 1.96 stated ones; velocities' rms from those of `still` [m/s]."""
    clear = (got["quality"].values & QUALITY_FLAGS["ambiguous"]) == 0
    ranges = got["range"].values
    counted = clear & (true["visible_fraction"].values > 0.5) & (ranges > NEAR_M) & (ranges < FAR_M)
    error = (got["height"].values - true["height"].values).astype(np.float64)
    known = counted & np.isfinite(error)
    within = float(np.mean(np.abs(error[known]) < 1.96 * got["height_std"].values[known]))
    if "radial_velocity" not in got:
        return [rms(error[known]), robust(error[known]), within, np.nan]
    off = (got["radial_velocity"].values - still["radial_velocity"].values).astype(np.float64)
    strong = known & (got["snr_db"].values > STRONG_DB) & np.isfinite(off)
    return [rms(error[known]), robust(error[known]), within, rms(off[strong])]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--forecast", type=int, default=0, metavar="TURNS")
    given = parser.parse_args()
    if given.forecast:
        forecast(given.seeds, given.forecast)
        return
    print(f"{'':28}{'':16}  p  height rms  robust  within  velocity rms")
    for mode in MODES:
        rows: dict[str, list[list[float]]] = {name: [] for name in TRANSMITTERS}
        paths = dict.fromkeys(TRANSMITTERS, 0)
        for seed in range(1, given.seeds + 1):
            still, _ = simulated(mode, seed, **{"radar.noise": False})
            for name, keys in TRANSMITTERS.items():
                if name == "magnetron" and mode.alternating:
                    continue
                got, true = simulated(mode, seed, **keys)
                paths[name] = int(got.attrs["paths"])
                rows[name].append(figures(got, true, still))
        for name, found in rows.items():
            if not found:
                print(f"{mode!s:28}{name:16}  refused", flush=True)
                continue
            height, sure, within, velocity = np.mean(found, axis=0)
            moving = "—" if np.isnan(velocity) else f"{velocity:.3f} m/s"
            print(
                f"{mode!s:28}{name:16}{paths[name]:3} {height:9.3f} m{sure:6.3f} m{within:8.1%}  {moving}", flush=True
            )


def forecast(seeds: int, turns: int) -> None:
    for name in ("coherent", "magnetron"):
        keys = {"radar.transmit": "single", **TRANSMITTERS[name]}
        made = [forecasts.run(forecasts.scene_of("choppy_sea", 301 + n, turns, **keys))[0] for n in range(seeds)]
        parts = forecasts.joined([each["boat"] for each in made])
        for lead, (first, last) in forecasts.LEADS.items():
            at = parts.figures(slice(first, last + 1))
            print(f"{name:12}{lead:10} correlation {at['corr']:.3f}  rms {at['rms']:.3f}  within {at['within']:.1%}")


if __name__ == "__main__":
    main()
