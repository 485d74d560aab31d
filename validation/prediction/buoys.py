"""Forecasts of the real ocean: three drifting buoys forecast the fourth, by the estimator that fits radar maps.

    python -m validation.prediction.buoys

Four SWIFT buoys off Portugal on 12 September 2022, 5 Hz, some 100–250 m apart, in a swell of 12 s from the west
(mbari-org/TheNextWave, example data, CC0 1.0; Thomson et al. 2024; Fisher et al. 2021), in validation/reference: metres
east, north and up, times by GPS. Each 11 s, so that all phases of the swell come up, three buoys' heights and
velocities of the last 100 s, without mean and trend, forecast the height at the fourth, which enters nowhere; the
expected spectrum is that of the same three buoys' last 100 s (Kuik, van Vledder & Holthuijsen 1988). The truth is the
fourth buoy's height without what is slower than 25 s. Skill is 1 − mean square error over variance; `ratio` is 1.4826
MAD of error over stated error, `within` the share of errors within 1.96 stated ones.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.signal import butter, detrend, sosfiltfilt

from seamap_rt.prediction import Observations, Spectrum, reconstruct, spectrum_of_buoys
from seamap_rt.settings import PredictionSettings

Field = NDArray[np.float64]

FILE = Path(__file__).parents[1] / "reference" / "swift_buoys.nc"
WINDOW_S, EACH_S = 100.0, 11.0
LEADS = np.arange(0.0, 21.0, 5.0)
MEAN_OF = 10  # samples, of the buoys' 5 Hz
HEIGHT_STD, VELOCITY_STD = 0.15, 0.15  # m, m/s: of a buoy that follows waves, and the waves that are not fitted


def buoys() -> xr.Dataset:
    """The record."""
    with xr.open_dataset(FILE, engine="h5netcdf") as record:
        return record.load().astype(np.float64)


def waves(height: Field) -> Field:
    """A height without what is slower than 25 s."""
    return sosfiltfilt(butter(4, 0.04, "highpass", fs=5.0, output="sos"), height)


def expected_spectrum(parts: list[xr.Dataset]) -> Spectrum:
    """By the mean of some buoys' velocities, of as many samples each."""
    names = ("velocity_up", "velocity_east", "velocity_north")
    samples = min(part.sizes["sample"] for part in parts)
    up, east, north = (np.stack([part[name].values[-samples:] for part in parts]) for name in names)
    return spectrum_of_buoys(up, east, north, 5.0)


def observed(parts: list[xr.Dataset]) -> Observations:
    """Heights and velocities of some buoys, means of two seconds."""
    kinds = {
        "altitude": ("elevation", HEIGHT_STD),
        "velocity_east": ("velocity_x", VELOCITY_STD),
        "velocity_north": ("velocity_y", VELOCITY_STD),
        "velocity_up": ("velocity_z", VELOCITY_STD),
    }

    def mean(values: Field) -> Field:
        return values[: values.size // MEAN_OF * MEAN_OF].reshape(-1, MEAN_OF).mean(axis=1)

    made = []
    for part in parts:
        x, y, time = (mean(part[name].values) for name in ("x", "y", "time"))
        for name, (kind, std) in kinds.items():
            value = mean(detrend(part[name].values))
            made.append(Observations(x, y, time, value, np.array([std]), np.array([kind])))
    return sum(made[1:], made[0])


def forecasts(record: xr.Dataset, left_out: int) -> tuple[Field, Field, Field]:
    """Expected, stated and true heights (issue, lead) at the buoy that is left out, m."""
    target = record.isel(buoy=left_out)
    others = [record.isel(buoy=number) for number in range(record.sizes["buoy"]) if number != left_out]
    height = waves(target["altitude"].values)
    first = max(float(each["time"][0]) for each in others) + WINDOW_S
    last = min(float(record.isel(buoy=number)["time"][-1]) for number in range(record.sizes["buoy"])) - LEADS[-1]
    rows = []
    for issue in np.arange(first, last, EACH_S):
        parts = []
        for each in others:
            inside = (each["time"].values > issue - WINDOW_S) & (each["time"].values <= issue)
            parts.append(each.isel(sample=inside))
        settings = PredictionSettings(lead_s=float(LEADS[-1]))
        field = reconstruct(settings=settings, observations=observed(parts), spectrum=expected_spectrum(parts))
        known = target["time"].values <= issue
        x, y = (float(target[name].values[known][-500:].mean()) for name in ("x", "y"))
        mean, std = field.elevation(x, y, issue + LEADS)
        rows.append((mean, std, np.interp(issue + LEADS, target["time"].values, height)))
    mean, std, truth = (np.array(part) for part in zip(*rows, strict=True))
    return mean, std, truth


def main() -> None:
    record = buoys()
    print("buoy  lead  skill  corr  stated/σ  ratio  within")
    for number, name in enumerate(record["buoy"].values):
        mean, std, truth = forecasts(record, number)
        sigma = float(np.std(waves(record["altitude"].values[number])))
        for n, lead in enumerate(LEADS):
            error = truth[:, n] - mean[:, n]
            away = error / np.hypot(std[:, n], HEIGHT_STD)
            print(
                f"{int(name):4d}{lead:6.0f}{1.0 - np.mean(error**2) / np.mean(truth[:, n] ** 2):7.2f}"
                f"{np.corrcoef(mean[:, n], truth[:, n])[0, 1]:6.2f}{np.sqrt(np.mean(std[:, n] ** 2)) / sigma:10.2f}"
                f"{1.4826 * np.median(np.abs(away)):7.2f}{np.mean(np.abs(away) < 1.96):8.0%}",
                flush=True,
            )


if __name__ == "__main__":
    main()
