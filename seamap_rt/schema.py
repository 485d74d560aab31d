"""The schema of all results: every variable's name, dimensions, type, units and CF attributes, in one table."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any


@dataclass(frozen=True)
class Variable:
    """One row of the schema: a variable's dimensions, type, units and CF names."""

    dims: tuple[str, ...]
    dtype: str
    units: str
    long_name: str
    standard_name: str | None = None
    required: bool = True

    def attributes(self) -> dict[str, Any]:
        attributes: dict[str, Any] = {"long_name": self.long_name, "units": self.units}
        if self.standard_name:
            attributes["standard_name"] = self.standard_name
        return attributes


QUALITY_FLAGS = {
    "no_echo": 1,
    "low_coherence": 2,
    "ambiguous": 4,
    "partly_shadowed": 8,
    "saturated": 16,
    "blind": 32,
    "submerged": 64,
}
_POLAR, _GROUND, _MOMENT, _READING = (
    ("turn", "azimuth", "range"),
    ("turn", "y", "x"),
    ("time", "y", "x"),
    ("gauge", "turn"),
)
_polar, _ground, _moment, _forecast, _drawn = (
    partial(Variable, dims, "float32")
    for dims in (_POLAR, _GROUND, _MOMENT, ("issue", "lead", "place"), ("issue", "draw", "lead", "place"))
)
_pulse, _range, _issue, _system = (
    partial(Variable, (dim,), "float64") for dim in ("pulse", "range", "issue", "system")
)
_reading = partial(Variable, _READING, "float64")
_SEA_HEIGHT = "sea_surface_height_above_mean_sea_level"
_DENSITY, _FROM = "sea_surface_wave_variance_spectral_density", "sea_surface_wave_from_direction"
_PEAK_PERIOD = "sea_surface_wave_period_at_variance_spectral_density_maximum"
_POLAR_COORDS = {
    "turn": Variable(("turn",), "int32", "1", "turn of the antenna"),
    "azimuth": Variable(("azimuth",), "float64", "degree", "azimuth of the look, clockwise from north"),
    "range": _range("m", "slant range of the gate, c t/2"),
}
_GROUND_COORDS = {
    "turn": Variable(("turn",), "int32", "1", "turn of the antenna"),
    "y": Variable(("y",), "float64", "m", "north of the origin", "projection_y_coordinate"),
    "x": Variable(("x",), "float64", "m", "east of the origin", "projection_x_coordinate"),
}
SCHEMA: dict[str, dict[str, Variable]] = {
    "echoes": {
        "pulse": Variable(("pulse",), "int64", "1", "number of the pulse since the start"),
        "range": _range("m", "range of the gate, c t/2"),
        "time": _pulse("s", "time of the pulse"),
        "azimuth": _pulse("degree", "bearing of the boresight at the pulse's middle, as the sensors have it"),
        "transmitter": Variable(
            ("pulse",), "int8", "1", "antenna that transmits: 0 lower, 1 upper; of more, in the scene's order"
        ),
        "turn": Variable(("pulse",), "int32", "1", "turn of the antenna"),
        "voltage": Variable(("pulse", "receiver", "range"), "complex64", "W^0.5", "complex receiver voltage"),
        "position": Variable(("pulse", "antenna", "xyz"), "float64", "m", "measured phase centres, east north up"),
        "attitude": Variable(("pulse", "rpy"), "float64", "degree", "measured roll, pitch, yaw of the boat"),
        "flag": Variable(("pulse",), "int16", "1", "quality flags that the radar itself knows", required=False),
        "saturated": Variable(
            ("pulse", "range"), "int8", "1", "1 where the converter of a receiver was overdriven", required=False
        ),
    },
    "polar_images": {
        "pulse": Variable(("pulse",), "int64", "1", "number of the radial since the start"),
        "range": _range("m", "range of the sample, c t/2 in air"),
        "time": _pulse("s", "time of the radial since the attribute start"),
        "azimuth": _pulse("degree", "bearing of the beam, clockwise from north"),
        "turn": Variable(("pulse",), "int32", "1", "turn of the antenna"),
        "video": Variable(("pulse", "range"), "uint16", "1", "received video in counts of the converter"),
        "heading": _pulse("degree", "heading of the ship, clockwise from north"),
        "latitude": _pulse("degrees_north", "latitude of the ship", "latitude"),
        "longitude": _pulse("degrees_east", "longitude of the ship", "longitude"),
    },
    "expected": {
        "azimuth": _POLAR_COORDS["azimuth"],
        "range": _POLAR_COORDS["range"],
        "transmitter": Variable(("transmitter",), "int32", "1", "antenna that transmits"),
        "receiver": Variable(("receiver",), "int32", "1", "antenna that receives"),
        "power": Variable(("transmitter", "receiver", "azimuth", "range"), "float64", "W", "expected echo power"),
        "covariance": Variable(("azimuth", "range"), "complex128", "W", "expected ⟨V_lower V_upper*⟩"),
    },
    "maps/polar": {
        **_POLAR_COORDS,
        "height": _polar("m", "retrieved height of the sea surface", _SEA_HEIGHT),
        "height_std": _polar("m", "standard error of the height"),
        "sensor_std": _polar("m", "part of height_std by the motion sensors", None, False),
        "analysis_std": _polar("m", "analysis error, part of height_std: by noise and speckle", None, False),
        "slope_range": _polar("1", "slope along the look, outward"),
        "slope_azimuth": _polar("1", "slope across the look, clockwise"),
        "slope_range_std": _polar("1", "standard error of the slope along the look", None, False),
        "slope_azimuth_std": _polar("1", "standard error of the slope across the look", None, False),
        "slope_correlation": _polar("1", "correlation of both slopes' errors", None, False),
        "ground_range": _polar("m", "horizontal distance at which the echo was placed"),
        "coherence": _polar("1", "magnitude of the coherence of the two receivers"),
        "phase": _polar("radian", "interferometric phase, wrapped, not flattened"),
        "phase_unwrapped": _polar("radian", "phase of the height found, ambiguity resolved"),
        "snr_db": _polar("dB", "signal to noise ratio of one pulse"),
        "radial_velocity": _polar("m s-1", "velocity of what echoes, away from the radar", None, False),
        "doppler_width": _polar("m s-1", "spread of the velocities in the cell", None, False),
        "visible_share": _polar("1", "share of the cell in sight, from the echoes", None, False),
        "dwell_height": _polar("m", "height by the echo of one dwell and gate alone", None, False),
        "dwell_height_std": _polar("m", "standard error of the dwell's own height", None, False),
        "antenna_x": Variable(_POLAR[:2], "float64", "m", "east of the antennas as the look was taken", None, False),
        "antenna_y": Variable(_POLAR[:2], "float64", "m", "north of the antennas as the look was taken", None, False),
        "crest_bias": _polar("m", "how far what is in sight stands above the cell's mean, estimated", None, False),
        "time": Variable(_POLAR[:2], "float64", "s", "time when the beam passes the look"),
        "quality": Variable(_POLAR, "int16", "1", "quality flags"),
    },
    "maps/ground": {
        **_GROUND_COORDS,
        "height": _ground("m", "retrieved height of the sea surface", _SEA_HEIGHT),
        "height_std": _ground("m", "standard error of the height"),
        "slope_x": _ground("1", "slope towards east"),
        "slope_y": _ground("1", "slope towards north"),
        "slope_x_std": _ground("1", "standard error of the slope towards east", None, False),
        "slope_y_std": _ground("1", "standard error of the slope towards north", None, False),
        "time": Variable(_GROUND, "float64", "s", "time when the beam passes the cell"),
    },
    "truth/polar": {
        **_POLAR_COORDS,
        "height": _polar("m", "true mean height of the cell, lit or not", _SEA_HEIGHT),
        "height_weighted": _polar("m", "true height weighted by beam and gate"),
        "height_visible": _polar("m", "true mean height of the cell's lit part"),
        "visible_fraction": _polar("1", "share of the cell's horizontal area that both antennas see"),
        "illumination": _polar("1", "diffraction's two-way power on the cell over that without shadow", required=False),
        "slope_range": _polar("1", "true mean slope along the look, outward"),
        "slope_azimuth": _polar("1", "true mean slope across the look, clockwise"),
        "nrcs_db": _polar("dB", "normalised radar cross section of the cell, dark parts included"),
        "time": Variable(_POLAR[:2], "float64", "s", "time when the beam passes the look"),
    },
    "truth/ground": {
        **_GROUND_COORDS,
        "height": _ground("m", "true mean height of the cell", _SEA_HEIGHT),
        "slope_x": _ground("1", "true mean slope towards east"),
        "slope_y": _ground("1", "true mean slope towards north"),
        "time": Variable(_GROUND, "float64", "s", "time when the beam passes the cell"),
    },
    "gauges": {  # the coordinate `gauge` holds their names
        "turn": _POLAR_COORDS["turn"],
        "time": Variable(("sample",), "float64", "s", "time of the wire's sample", required=False),
        "east": Variable(("gauge",), "float64", "m", "east of the origin"),
        "north": Variable(("gauge",), "float64", "m", "north of the origin"),
        "true_height": Variable(
            ("gauge", "sample"),
            "float64",
            "m",
            "true height of the surface at the gauge, sampled by time",
            _SEA_HEIGHT,
            False,
        ),
        "height": Variable(_READING, "float32", "m", "retrieved height of the map at the gauge", _SEA_HEIGHT),
        "height_std": Variable(_READING, "float32", "m", "standard error of the retrieved height"),
        "seen_time": _reading("s", "time of the map at the gauge"),
        "quality": Variable(_READING, "int16", "1", "quality flags of the polar cell in which the gauge stands"),
        "seen_true_height": _reading("m", "true height of the surface at the gauge at seen_time", _SEA_HEIGHT, False),
        "seen_cell_height": _reading("m", "true mean height of the map's cells at the gauge at seen_time", None, False),
    },
    "prediction": {
        "issue": Variable(("issue",), "int32", "1", "number of the forecast"),
        "lead": Variable(("lead",), "float64", "s", "time after the last that was seen"),
        "place": Variable(("place",), "int32", "1", "number of the place"),
        "east": Variable(("issue", "place"), "float64", "m", "place east of the origin at the time of issue"),
        "north": Variable(("issue", "place"), "float64", "m", "place north of the origin at the time of issue"),
        "issued": _issue("s", "time of the last that was seen"),
        "turns": Variable(("issue",), "int32", "1", "turns that the forecast rests on"),
        "significant_wave_height": _issue("m", "of the sea that the maps show"),
        "peak_period": _issue("s", "of the sea that the maps show"),
        "elevation": _forecast("m", "expected height of the sea surface", _SEA_HEIGHT),
        "elevation_std": _forecast("m", "standard error of the elevation"),
        "slope_x": _forecast("1", "expected slope towards east"),
        "slope_x_std": _forecast("1", "standard error of the slope towards east"),
        "slope_y": _forecast("1", "expected slope towards north"),
        "slope_y_std": _forecast("1", "standard error of the slope towards north"),
        "velocity_z": _forecast("m s-1", "expected velocity of the water at the surface, up"),
        "velocity_z_std": _forecast("m s-1", "standard error of that velocity"),
        "heave": _forecast("m", "expected heave of the vessel, up", None, False),
        "heave_std": _forecast("m", "standard error of the heave", None, False),
        "roll": _forecast("degree", "expected roll, starboard down", "platform_roll_starboard_down", False),
        "roll_std": _forecast("degree", "standard error of the roll", None, False),
        "pitch": _forecast("degree", "expected pitch, bow up", "platform_pitch_fore_up", False),
        "pitch_std": _forecast("degree", "standard error of the pitch", None, False),
        "elevation_draw": _drawn("m", "heights that may come", None, False),
        "slope_x_draw": _drawn("1", "slopes towards east that may come", None, False),
        "slope_y_draw": _drawn("1", "slopes towards north that may come", None, False),
        "velocity_z_draw": _drawn("m s-1", "velocities up that may come", None, False),
        "heave_draw": _drawn("m", "heaves that may come", None, False),
        "roll_draw": _drawn("degree", "rolls that may come", None, False),
        "pitch_draw": _drawn("degree", "pitches that may come", None, False),
        "quiet": _forecast("1", "probability of a quiet window from then on", None, False),
        "predictable": _forecast("1", "share of the sea's variance that is known"),
        "maximum_prediction_time": Variable(
            ("issue", "place"), "float32", "s", "lead up to which elevation_std is below half of the sea's", None, False
        ),
    },
    "sea": {
        # CF counts time from a date: a nominal one, the scene's time 0.
        "time": Variable(("time",), "float64", "seconds since 2000-01-01 00:00:00", "time of the scene", "time"),
        "y": _GROUND_COORDS["y"],
        "x": _GROUND_COORDS["x"],
        "sea_surface_height": _moment("m", "height of the sea surface", _SEA_HEIGHT),
        "slope_x": _moment("1", "slope of the sea surface towards east"),
        "slope_y": _moment("1", "slope of the sea surface towards north"),
        "velocity_x": _moment("m s-1", "the water particle's velocity at the surface, east", "sea_water_x_velocity"),
        "velocity_y": _moment("m s-1", "the water particle's velocity at the surface, north", "sea_water_y_velocity"),
        "velocity_z": _moment("m s-1", "the water particle's velocity at the surface, up", "upward_sea_water_velocity"),
        "nrcs_db": _moment("dB", "normalised radar cross section towards the radar, where lit"),
        "visible": Variable(_MOMENT, "int8", "1", "antennas that see the sea; -1 where the radar does not look"),
    },
    "recorded_sea": {
        "time": Variable(("time",), "float64", "seconds since 2000-01-01 00:00:00", "time of the scene", "time"),
        "y": _GROUND_COORDS["y"],
        "x": _GROUND_COORDS["x"],
        "elevation": _moment("m", "height of the sea surface", _SEA_HEIGHT),
        "surface_potential": _moment(
            "m2 s-1", "velocity potential of the waves, at the surface; a current is not in it"
        ),
    },
    "sea/spectrum": {
        "frequency": Variable(("frequency",), "float64", "Hz", "frequency in the water's frame", "wave_frequency"),
        "direction": Variable(("direction",), "float64", "degree", "azimuth the waves come from", _FROM),
        "system": Variable(("system",), "int32", "1", "number of the wave system in the scene, from 0"),
        "directional_spectrum": Variable(
            ("frequency", "direction"),
            "float64",
            "m2 s degree-1",
            "expected directional spectrum of the short-crested systems together",
            "sea_surface_wave_directional_variance_spectral_density",
        ),
        "frequency_spectrum": Variable(
            ("frequency",), "float64", "m2 s", "expected spectrum of all random systems together", _DENSITY
        ),
        "system_spectrum": Variable(
            ("system", "frequency"),
            "float64",
            "m2 s",
            "expected spectrum of each system; 0 for a regular wave, which is a single line",
            _DENSITY,
        ),
        "system_kind": Variable(("system",), "int8", "1", "what kind of system it is"),
        "system_height": _system("m", "significant height, of a regular wave crest to trough; all its waves counted"),
        "system_period": _system("s", "peak period, of a regular wave its period", _PEAK_PERIOD),
        "system_direction": _system("degree", "mean azimuth the waves come from", _FROM),
    },
}


# The radar's properties that a retrieval needs, as attributes of the echoes: name → units and meaning.
ECHO_ATTRIBUTES: dict[str, str] = {
    "frequency_hz": "Hz, carrier",
    "pulse_width_s": "s, transmitted pulse",
    "bandwidth_hz": "Hz, noise bandwidth of the receiver",
    "prf_hz": "Hz, pulses per second",
    "rotation_rpm": "turns per minute",
    "sector_deg": "degree, start and stop azimuth of the sector that is looked at",
    "height_m": "m, mean height of the two phase centres above mean sea level",
    "baseline_m": "m, distance between the phase centres",
    "tilt_deg": "degree, lean of the baseline, top towards the look",
    "azimuth_beamwidth_deg": "degree, one-way −3 dB",
    "elevation_beamwidth_deg": "degree, one-way −3 dB",
    "polarization": "VV or HH",
    "transmit": "single or switched",
    "interferogram": "single_pulse or alternating_pulse",
    "noise_power_w": "W, expected noise of one gate and receiver; 0 when no noise was added",
    "complete_turns": "turns that are whole in this file",
}


# Attributes that may be missing: name → default, units and meaning.
FURTHER_ECHO_ATTRIBUTES: dict[str, tuple[Any, str]] = {
    "waveform": ("pulse", "pulse or chirp"),
    "chirp_bandwidth_hz": (0.0, "Hz, swept by a chirp"),
    "compression_weighting": ("none", "none, hann, hamming or taylor: of the chirp's matched filter"),
    "scan": ("turning", "turning or staring"),
    "stare_s": (0.05, "s, of a map of a staring antenna"),
    "receiver_antennas": ([0, 1], "antenna of each receiver"),
    "transmitter": ("coherent", "coherent or magnetron: whether pulses start with one phase or each with its own"),
    "coherent_on_receive": (0, "1 where the receiver has taken off the phase of each pulse as a magnetron sent it"),
    "transmit_phase_error_deg": (0.0, "degree, rms error of the phase that was taken off"),
    **dict.fromkeys(
        ("sensors_attitude_noise_deg", "sensors_heading_noise_deg", "sensors_position_noise_m", "sensors_latency_s"),
        (0.0, "rms of a reading of the motion, and its age; unknown where no attribute tells of sensors"),
    ),
    **dict.fromkeys(
        ("sensors_attitude_accuracy_deg", "sensors_heading_accuracy_deg", "sensors_height_accuracy_m"),
        (0.0, "rms of a sensor's constant error; 0: not stated"),
    ),
    "sensors_rate_hz": (1e9, "Hz, readings of the motion"),
    "retrieval": ("{}", "JSON of the keys of [retrieval] that are not their defaults, by which `retrieve` goes"),
}


# What waves run on, carried as attributes of the maps: name → what is taken where it is missing, units and meaning.
WATER_ATTRIBUTES: dict[str, tuple[Any, str]] = {
    "depth_m": (float("inf"), "m, depth of the water; inf is deep"),
    "depth_given": (0, "1 where the depth was given, 0 where deep water was assumed"),
    "current_m_s": ([0.0, 0.0], "m/s, current towards east and north"),
}
