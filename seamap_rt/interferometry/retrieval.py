"""The retrieval, step by step: covariance, phase, flattening, height, slope, error bar, flags, ground map."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..analytic.phase import phase_std_lee94
from ..conventions import SPEED_OF_LIGHT, db, unit_from_azimuth, wrap_degrees, wrap_phase
from ..dataset import QUALITY_FLAGS, SchemaError, build, check
from ..radar.grid import LookFan, ground_grid
from ..radar.scan import look_sweeps
from ..radar.waveform import RangeResponse
from ..settings import RetrievalSettings
from .covariance import Covariance, dwell_covariance, independent_looks, pulse_correlation, window_weights
from .ground import resample_looks, sample_fan
from .inversion import difference_at_height, height_and_ground_range, height_per_phase, path_share
from .slopes import local_plane

_SHADOW_DB = 20.0  # a cell this far below its gate's median has no echo of its own, only its neighbours' skirts
_LOW_COHERENCE = 0.3
_PARTLY_SHADOWED_DB = 8.0
_GROUND_SAMPLES = 3  # per side of a ground cell


def retrieve(echoes: xr.Dataset | str | Path, settings: RetrievalSettings | None = None) -> xr.DataTree:
    """Maps (`/polar`, `/ground`) from echoes that keep the schema, ray traced, analytic or recorded alike.

    Raises SchemaError, in one line, for echoes that do not keep the schema.
    """
    settings = settings or RetrievalSettings()
    if not isinstance(echoes, xr.Dataset):
        echoes = open_echoes(echoes)
    check("echoes", echoes)
    turns = []
    for turn in range(int(echoes.attrs["complete_turns"])):
        members = np.flatnonzero(echoes["turn"].values == turn)
        if members.size:
            turns.append(retrieve_one(echoes.isel(pulse=slice(int(members[0]), int(members[-1]) + 1)), settings))
    if not turns:
        raise SchemaError("the echoes hold no complete turn; simulate or record at least one")
    return xr.DataTree.from_dict(
        {
            f"/{group}": xr.concat([t[group].to_dataset() for t in turns], "turn", data_vars="minimal")
            for group in ("polar", "ground")
        }
    )


def retrieve_one(echoes: xr.Dataset, settings: RetrievalSettings | None = None) -> xr.DataTree:
    """Maps of the single turn that these echoes hold."""
    settings = settings or RetrievalSettings()
    radar = RadarDescription.of(echoes)
    turn = int(echoes["turn"].values[0])
    cells = retrieve_turn(echoes, radar, settings, turn)
    return xr.DataTree.from_dict({"/polar": cells, "/ground": ground_map(cells, radar, settings, turn)})


def open_echoes(path: str | Path) -> xr.Dataset:
    """Echoes from a Zarr store, complete turns only; raises SchemaError if the store does not keep the schema."""
    dataset = xr.open_zarr(path, consolidated=False, zarr_format=3)
    dataset = dataset.set_coords([n for n in ("time", "azimuth", "transmitter", "turn") if n in dataset])
    check("echoes", dataset)
    whole = int(np.count_nonzero(dataset["turn"].values < dataset.attrs["complete_turns"]))
    return dataset.isel(pulse=slice(0, whole))


@dataclass(frozen=True)
class RadarDescription:
    """What the echoes' attributes say of the radar."""

    wavelength: float
    noise_power: float
    transmit: str
    sector: tuple[float, float]
    period: float
    height: float
    response: RangeResponse
    ranges: NDArray[np.float64]

    @classmethod
    def of(cls, echoes: xr.Dataset) -> RadarDescription:
        attrs = echoes.attrs
        if attrs["interferogram"] != "single_pulse":
            raise SchemaError(
                f"interferogram = '{attrs['interferogram']}': only single_pulse echoes can be retrieved so far"
            )
        start, stop = (float(a) for a in attrs["sector_deg"])
        return cls(
            wavelength=SPEED_OF_LIGHT / float(attrs["frequency_hz"]),
            noise_power=float(attrs["noise_power_w"]),
            transmit=str(attrs["transmit"]),
            sector=(start, stop),
            period=60.0 / float(attrs["rotation_rpm"]),
            height=float(attrs["height_m"]),
            response=RangeResponse(float(attrs["pulse_width_s"]), float(attrs["bandwidth_hz"])),
            ranges=np.asarray(echoes["range"].values, dtype=np.float64),
        )

    @property
    def spacing(self) -> float:
        return float(self.ranges[1] - self.ranges[0]) if self.ranges.size > 1 else 1.0

    @property
    def closed(self) -> bool:
        return bool(np.isclose(self.sector[1] - self.sector[0], 360.0))


@dataclass(frozen=True)
class LookGeometry:
    """Each look's antennas, from the boat's sensors; arrays (look, 1)."""

    baseline: NDArray[np.float64]
    lower_height: NDArray[np.float64]
    tilt: NDArray[np.float64]  # rad, of the baseline in the plane of the look, top outward
    offset: NDArray[np.float64]  # m, of the lower antenna along the look from the origin's vertical


def retrieve_turn(echoes: xr.Dataset, radar: RadarDescription, settings: RetrievalSettings, turn: int) -> xr.Dataset:
    """The polar maps of one turn."""
    sweeps = look_sweeps(radar.sector, settings.cell_azimuth_deg)
    width = float(sweeps[1] - sweeps[0]) if sweeps.size > 1 else settings.cell_azimuth_deg
    azimuth = (radar.sector[0] + sweeps) % 360.0
    look = _look_of_pulses(echoes, radar, sweeps, width)
    voltage = np.asarray(echoes["voltage"].values)
    time = np.asarray(echoes["time"].values, dtype=np.float64)
    geometry = _look_geometry(echoes, look, azimuth)

    share = path_share(radar.transmit)
    wavenumber = 2.0 * np.pi / radar.wavelength

    def flat_phase(offset: float) -> NDArray[np.float64]:
        """Phase (look, gate) of mean sea level `offset` beyond each gate."""
        return wavenumber * difference_at_height(
            radar.ranges + offset, 0.0, geometry.baseline, geometry.lower_height, geometry.tilt, share
        )

    flat = flat_phase(0.0)
    flat_per_gate = 0.5 * (flat_phase(radar.spacing) - flat_phase(-radar.spacing))

    def invert(departure: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Height, ground range and |dz/dφ| from the phase's departure from that of mean sea level. Departures beyond
        half an ambiguity are folded so far; `ambiguous` flags where the sea may be that high."""
        difference = (flat + departure) / wavenumber
        height, place = height_and_ground_range(
            radar.ranges, difference, geometry.baseline, geometry.lower_height, geometry.tilt, share
        )
        return (
            height,
            place,
            height_per_phase(radar.ranges, difference, geometry.baseline, geometry.tilt, radar.wavelength),
        )

    dwell = dwell_covariance(voltage, look, sweeps.size)
    own = (window_weights(settings.cell_range_m, radar.spacing), window_weights(settings.cell_azimuth_deg, width))
    window = (
        window_weights(settings.window_range_m, radar.spacing),
        window_weights(settings.window_azimuth_deg, width),
    )
    cells = dwell.windowed_along(*own, phase_per_gate=flat_per_gate, phase_per_look=np.zeros(1))
    departure = wrap_phase(np.angle(cells.cross) - flat)
    height, ground_range, gain = invert(departure)
    if settings.estimator == "sliding_plane":
        outward, clockwise = _slopes(height, ground_range, cells.lower, radar, settings, width)
        per_height = np.nan_to_num(1.0 / gain, posinf=0.0, neginf=0.0)
        step = _ground_step(radar, ground_range, geometry.lower_height - height, outward)
        cells = dwell.windowed_along(
            *window,
            phase_per_gate=flat_per_gate + _phase_slope(outward * step, per_height),
            phase_per_look=_phase_slope(clockwise * ground_range * np.radians(width), per_height),
        )
        departure = wrap_phase(np.angle(cells.cross) - flat)
        height, ground_range, gain = invert(departure)
    else:
        window = own
    unwrapped = flat + departure

    echo_power = 0.5 * (cells.lower + cells.upper) - radar.noise_power
    echoing = _has_echo(cells, echo_power, radar, settings)
    heard = echoing & np.isfinite(height)
    spread = _height_std(voltage, look, dwell.turned(flat), echo_power, gain, radar, *window)
    height, ground_range, spread = (np.where(heard, f, np.nan) for f in (height, ground_range, spread))
    outward, clockwise = _slopes(height, ground_range, cells.lower, radar, settings, width)
    quality = _flags(echoes, look, cells, echoing, echo_power, gain, height, radar)
    with np.errstate(invalid="ignore", divide="ignore"):
        snr = (
            db(np.where(echo_power > 0.0, echo_power, np.nan) / radar.noise_power)
            if radar.noise_power
            else echo_power * np.inf
        )
    snr = np.where(np.isfinite(snr), snr, np.nan)

    def one(field: NDArray) -> NDArray:
        return np.asarray(field)[None]

    period_time = (turn + sweeps / 360.0) * radar.period
    measured = np.bincount(look[look >= 0], weights=time[look >= 0], minlength=sweeps.size)
    pulses = np.bincount(look[look >= 0], minlength=sweeps.size)
    look_time = np.where(pulses > 0, measured / np.maximum(pulses, 1), period_time)
    return build(
        "maps/polar",
        {
            "height": one(height),
            "height_std": one(spread),
            "slope_range": one(outward),
            "slope_azimuth": one(clockwise),
            "ground_range": one(ground_range + geometry.offset),
            "coherence": one(cells.coherence),
            "phase": one(wrap_phase(unwrapped)),
            "phase_unwrapped": one(np.where(heard, unwrapped, np.nan)),
            "snr_db": one(snr),
            "time": one(look_time),
            "quality": one(quality),
        },
        {"turn": [turn], "azimuth": azimuth, "range": radar.ranges},
        {
            "cell_range_m": settings.cell_range_m,
            "cell_azimuth_deg": settings.cell_azimuth_deg,
            "estimator": settings.estimator,
            "window_range_m": settings.window_range_m,
            "window_azimuth_deg": settings.window_azimuth_deg,
        },
    )


def ground_map(cells: xr.Dataset, radar: RadarDescription, settings: RetrievalSettings, turn: int) -> xr.Dataset:
    """The ground maps of one turn: each square cell the mean of a few samples of the polar map at its places."""
    grid = ground_grid(float(radar.ranges[-1]), settings.ground_m)
    fan = LookFan(
        look_sweeps(radar.sector, settings.cell_azimuth_deg), radar.sector[0], radar.closed, radar.period, turn
    )
    outward, clockwise = cells["slope_range"].values[0], cells["slope_azimuth"].values[0]
    east, north = unit_from_azimuth(cells["azimuth"].values)
    fields = {
        "height": cells["height"].values[0],
        "height_std": cells["height_std"].values[0],
        # Outward is (east, north); clockwise of it is (north, −east).
        "slope_x": outward * east[:, None] + clockwise * north[:, None],
        "slope_y": outward * north[:, None] - clockwise * east[:, None],
    }
    fields = {name: np.asarray(field, dtype=np.float64) for name, field in fields.items()}
    distance = np.arange(0.5 * settings.ground_m, radar.ranges[-1] + settings.ground_m, 0.25 * settings.ground_m)
    resampled = resample_looks(
        cells["ground_range"].values[0].astype(np.float64),
        fields,
        distance,
        1.5 * settings.cell_range_m + radar.spacing,
    )
    centre_x, centre_y = np.meshgrid(grid.x, grid.y)
    sweep = fan.sweep_of(centre_x, centre_y)
    inside = np.hypot(centre_x, centre_y) <= radar.ranges[-1]
    x, y = grid.points(_GROUND_SAMPLES)
    # A cell that straddles the start of the turn stays on its centre's side: the other is a turn older or younger.
    beside = wrap_degrees(fan.sweep_of(x, y) - sweep[..., None])
    sampled = sample_fan(fan, resampled, distance, sweep[..., None] + beside, np.hypot(x, y))
    if not radar.closed:
        inside &= sweep <= radar.sector[1] - radar.sector[0]

    def mean(field: NDArray[np.float64]) -> NDArray[np.float64]:
        known = np.isfinite(field)
        count = known.sum(axis=2)
        total = np.where(known, field, 0.0).sum(axis=2)
        return np.where(2 * count > field.shape[2], total / np.maximum(count, 1), np.nan)[None]

    values = {name: mean(field) for name, field in sampled.items()}
    values["time"] = np.where(inside, fan.time(sweep), np.nan)[None]
    return build("maps/ground", values, {"turn": [turn], "y": grid.y, "x": grid.x}, {"cell_m": settings.ground_m})


# --------------------------------------------------------------------------------------------------- steps


def _look_of_pulses(
    echoes: xr.Dataset, radar: RadarDescription, sweeps: NDArray[np.float64], width: float
) -> NDArray[np.intp]:
    """The look in whose dwell each pulse lies, or −1."""
    # Relative to the sector's middle, so that a pulse at its very edge cannot wrap to the other side.
    middle = 0.5 * (radar.sector[0] + radar.sector[1])
    sweep = wrap_degrees(np.asarray(echoes["azimuth"].values) - middle) + 0.5 * (radar.sector[1] - radar.sector[0])
    number = np.floor((sweep - sweeps[0]) / width + 0.5 + 1e-9).astype(np.intp)
    return np.where((number >= 0) & (number < sweeps.size), number, -1)


def _look_geometry(echoes: xr.Dataset, look: NDArray[np.intp], azimuth: NDArray[np.float64]) -> LookGeometry:
    """Mean antenna positions over each look's pulses, as the sensors measured them."""
    position = np.asarray(echoes["position"].values, dtype=np.float64)
    east, north = unit_from_azimuth(np.asarray(echoes["azimuth"].values))
    lower = position[:, 0]
    base = position[:, 1] - position[:, 0]
    along = base[:, 0] * east + base[:, 1] * north
    values = np.stack(
        (np.linalg.norm(base, axis=1), lower[:, 2], along, base[:, 2], lower[:, 0] * east + lower[:, 1] * north)
    )
    good = (look >= 0) & np.isfinite(values).all(axis=0)
    count = np.bincount(look[good], minlength=azimuth.size)
    with np.errstate(invalid="ignore"):
        mean = [np.bincount(look[good], weights=v[good], minlength=azimuth.size) / np.maximum(count, 1) for v in values]
    mean = [np.where(count > 0, m, np.nan)[:, None] for m in mean]
    return LookGeometry(mean[0], mean[1], np.arctan2(mean[2], mean[3]), mean[4])


def _slopes(
    height: NDArray[np.float64],
    ground_range: NDArray[np.float64],
    power: NDArray[np.float64],
    radar: RadarDescription,
    settings: RetrievalSettings,
    width: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Slopes outward and clockwise by planes over three looks and a cell and a half to either side: 10.5 m by default.

    Shorter planes would follow steeper waves, and more noise. Strong echoes count for more, up to thrice the median.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        relative = power / _gate_median(power, np.isfinite(power))
    weight = np.where(np.isfinite(height), np.clip(np.nan_to_num(relative), 0.0, 3.0), 0.0)
    across = np.where(np.isfinite(ground_range), ground_range, radar.ranges) * np.radians(width)
    reach = (1, max(1, round(1.5 * settings.cell_range_m / radar.spacing)))
    # Not closed: the first and the last look of a circle are neighbours in place, but lie a turn apart in time.
    return local_plane(height, weight, ground_range, across, reach, closed=False)


def _ground_step(
    radar: RadarDescription,
    ground_range: NDArray[np.float64],
    drop: NDArray[np.float64],
    slope: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Ground range from a gate to the next along a surface of that slope: r dr = (x − drop · slope) dx.

    Kept within three gates' spacing: where the surface faces the radar squarely, many places share a gate.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        step = radar.ranges / (ground_range - drop * np.nan_to_num(slope))
    return radar.spacing * np.clip(np.where(step > 0.0, step, 3.0), 0.0, 3.0)


def _phase_slope(rise: NDArray[np.float64], per_height: NDArray[np.float64]) -> NDArray[np.float64]:
    """Height difference to the neighbour as phase; 0 where the slope is unknown. A rise turns the phase back."""
    return -np.nan_to_num(rise) * per_height


def _gate_median(power: NDArray[np.float64], known: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Median over the looks of each gate's known cells (1, gate); 0 where none is known."""
    median = np.zeros((1, power.shape[1]))
    some = known.any(axis=0)
    if some.any():
        median[0, some] = np.nanmedian(np.where(known, power, np.nan)[:, some], axis=0)
    return median


def _has_echo(
    cells: Covariance, echo_power: NDArray[np.float64], radar: RadarDescription, settings: RetrievalSettings
) -> NDArray[np.bool_]:
    """Cells with an echo of their own: above the noise, and not merely the skirts of lit neighbours."""
    with np.errstate(invalid="ignore"):
        # A dead receiver leaves no cross term, whose angle would read as a flat sea.
        heard = np.isfinite(cells.cross) & (echo_power > 0.0) & (cells.lower > 0.0) & (cells.upper > 0.0)
        if radar.noise_power:
            heard &= db(np.maximum(echo_power, 0.0) / radar.noise_power) >= settings.min_snr_db
        typical = _gate_median(echo_power, heard)
        return heard & (echo_power > typical * 10.0 ** (-_SHADOW_DB / 10.0))


def _height_std(
    voltage: NDArray[np.complex64],
    look: NDArray[np.intp],
    dwell: Covariance,
    echo_power: NDArray[np.float64],
    gain: NDArray[np.float64],
    radar: RadarDescription,
    range_weights: NDArray[np.float64],
    look_weights: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Standard error of the height: speckle and noise, which average at different rates, added in square.

    Speckle: Lee's statistics with the coherence that is left when the noise's share is taken out, from a wider window
    (one look's own coherence says nothing), and as many samples as the dwell's measured correlation leaves. Noise: it
    is new at every pulse; phase variance (2/SNR + 1/SNR²)/2N with the cell's own, faded SNR.
    """
    pulses = max(1, int(np.median(np.bincount(look[look >= 0])))) if (look >= 0).any() else 1
    correlation = pulse_correlation(voltage, look, radar.noise_power, pulses - 1)
    lags = radar.spacing * np.arange(range_weights.size)
    fine = np.linspace(-2.0 * radar.response.support_m, 2.0 * radar.response.support_m, 801)
    pulse = radar.response(fine)
    echo_lag = np.array([pulse @ radar.response(fine + lag) for lag in lags]) / (pulse @ pulse)
    in_azimuth = independent_looks(look_weights, np.eye(1, look_weights.size).ravel())
    looks = independent_looks(np.ones(pulses), correlation) * independent_looks(range_weights, echo_lag) * in_azimuth
    samples = pulses * independent_looks(range_weights, radar.response.noise_correlation(lags)) * in_azimuth

    wide = dwell.windowed(
        np.ones(2 * max(2, range_weights.size // 2 + 1) + 1), np.ones(2 * (look_weights.size // 2) + 3)
    )
    with np.errstate(invalid="ignore", divide="ignore"):
        clean = np.maximum(wide.lower - radar.noise_power, 0.0) * np.maximum(wide.upper - radar.noise_power, 0.0)
        coherence = np.clip(np.nan_to_num(np.abs(wide.cross) / np.sqrt(clean), posinf=1.0), 0.0, 0.999999)
        noise = radar.noise_power / np.maximum(echo_power, 0.0)
        from_noise = (2.0 * noise + noise**2) / (2.0 * samples)
    speckle = np.interp(coherence, *_lee_table(round(max(1.0, looks), 1)))
    # A phase cannot be worse known than not at all: uniform over the circle.
    return gain * np.sqrt(np.minimum(speckle**2 + from_noise, np.pi**2 / 3.0))


@lru_cache(maxsize=64)
def _lee_table(looks: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Coherences, and the phase's standard deviation at them for a number of looks."""
    coherence = np.concatenate((np.linspace(0.0, 0.95, 16), 1.0 - np.geomspace(0.04, 1e-6, 16)))
    return coherence, phase_std_lee94(coherence, looks)


def _flags(
    echoes: xr.Dataset,
    look: NDArray[np.intp],
    cells: Covariance,
    heard: NDArray[np.bool_],
    echo_power: NDArray[np.float64],
    gain: NDArray[np.float64],
    height: NDArray[np.float64],
    radar: RadarDescription,
) -> NDArray[np.int16]:
    """CF flags of each cell, from the echo alone."""
    quality = np.zeros(heard.shape, dtype=np.int16)
    quality[~heard] |= QUALITY_FLAGS["no_echo"]
    with np.errstate(invalid="ignore"):
        quality[heard & (cells.coherence < _LOW_COHERENCE)] |= QUALITY_FLAGS["low_coherence"]
        # Half an ambiguity is π·gain. The sea's own size, as far as it shows, says where heights may lie beyond it.
        known = height[np.isfinite(height)]
        size = 1.4826 * np.median(np.abs(known - np.median(known))) if known.size else 0.0
        quality[heard & ((np.pi * gain < 3.0 * size) | ~np.isfinite(height))] |= QUALITY_FLAGS["ambiguous"]
        typical = _gate_median(echo_power, heard)
        weak = echo_power < typical * 10.0 ** (-_PARTLY_SHADOWED_DB / 10.0)
        quality[heard & weak] |= QUALITY_FLAGS["partly_shadowed"]
    # The receiver is blind while the pulse goes out.
    quality[:, radar.ranges < 0.5 * SPEED_OF_LIGHT * radar.response.pulse_width_s] |= QUALITY_FLAGS["blind"]
    if "flag" in echoes:
        flags = np.asarray(echoes["flag"].values)
        for number in np.unique(look[(look >= 0) & (flags != 0)]):
            quality[number] |= np.bitwise_or.reduce(flags[look == number])
    return quality


__all__ = ["RadarDescription", "ground_map", "open_echoes", "retrieve", "retrieve_one", "retrieve_turn"]
