"""What a page calls the keys of a scene: words and units that people use, with the factor from the key's own unit."""

from __future__ import annotations

from decimal import Decimal, InvalidOperation
from typing import Any

from ..io.text import parse_number

_ENDINGS = ("_m_s", "_dbsm", "_dbm", "_dbi", "_deg", "_rpm", "_psu", "_hz", "_db", "_m", "_s", "_w", "_c")

_LABELS = {
    "adc_bits": "Converter bits",
    "adc_rate_hz": "Converter rate",
    "agc_headroom_db": "Automatic gain headroom",
    "azimuth_beamwidth_deg": "Beam width, azimuth",
    "baseline_m": "Baseline between the antennas",
    "calibrated_to": "Mean echo calibrated to",
    "cell_azimuth_deg": "Cell width",
    "cell_range_m": "Cell length",
    "coherent_s": "Pulses added for",
    "current_toward_deg": "Current flows towards",
    "depth_m": "Water depth",
    "elevation_beamwidth_deg": "Beam width, elevation",
    "energy_fraction": "Share of the waves resolved",
    "extent_m": "Side of the patch of sea",
    "facet_m": "Facet length",
    "full_scale_dbm": "Converter full scale",
    "gain_dbi": "Antenna gain",
    "ground_m": "Ground cell",
    "height_error_m": "Height error allowed to the mesh",
    "if_hz": "Intermediate frequency",
    "kind": "Format",
    "lead_s": "Forecast ahead",
    "list_deg": "List to starboard",
    "losses_db": "System losses",
    "min_snr_db": "Least signal to noise",
    "noise": "Receiver noise",
    "nrcs": "Echo model",
    "nrcs_db": "Constant σ0",
    "peak_enhancement": "Peak enhancement γ",
    "peak_period_s": "Peak period Tp",
    "prf_hz": "Pulse repetition",
    "radar.height_m": "Antenna height above the sea",
    "range_m": "Range window",
    "range_sampling_m": "Gate spacing",
    "rcs_dbsm": "Radar cross-section",
    "resolution_m": "Spacing of the resolved waves",
    "significant_wave_height_m": "Significant wave height Hs",
    "spreading_exponent": "Spreading exponent s",
    "stc_exponent": "Sensitivity-time exponent",
    "stc_range_m": "Sensitivity-time range",
    "transmit": "Transmitters",
    "trim_deg": "Trim, bow up",
    "velocity_z_m_s": "Water speed upwards stays below",
    "quiet.elevation_m": "Water height stays below",
    "quiet.heave_m": "Heave stays below",
    "quiet.roll_deg": "Roll stays below",
    "quiet.pitch_deg": "Pitch stays below",
    "quiet.duration_s": "Window lasts",
    "wave_from_deg": "Waves come from",
    "wind_from_deg": "Wind blows from",
    "sinusoid.height_m": "Wave height, crest to trough",
}

_SECTIONS = {
    "": "Run",
    "sea": "Sea",
    "sea.waves": "Waves",
    "scattering": "Wind and echo",
    "radar": "Radar",
    "radar.antenna": "Antenna pattern",
    "radar.antennas": "Placed antennas",
    "radar.receiver": "Receiver",
    "platform": "Boat",
    "platform.sensors": "Motion sensors",
    "objects": "Objects",
    "gauges": "Wave gauges",
    "tracing": "Shadows and mesh",
    "retrieval": "Retrieval",
    "prediction": "Forecast",
    "prediction.vessel": "Vessel",
    "prediction.quiet": "Quiet windows",
}

_SHOWN = {  # leaf: the unit that people use, and how many of the key's own it is
    "frequency_hz": ("GHz", "1e9"),
    "design_frequency_hz": ("GHz", "1e9"),
    "bandwidth_hz": ("MHz", "1e6"),
    "chirp_bandwidth_hz": ("MHz", "1e6"),
    "if_hz": ("MHz", "1e6"),
    "adc_rate_hz": ("MHz", "1e6"),
    "prf_hz": ("kHz", "1e3"),
    "pulse_width_s": ("ns", "1e-9"),
    "decorrelation_time_s": ("ms", "1e-3"),
    "coherent_s": ("ms", "1e-3"),
    "stare_s": ("ms", "1e-3"),
    "guide_width_m": ("mm", "1e-3"),
    "fetch_m": ("km", "1e3"),
}


def label_of(key: str) -> str:
    """Of a key, as "radar.height_m" or "sea.waves.0.peak_period_s": words without unit."""
    parts = [part for part in key.split(".") if not part.isdigit()]
    leaf = parts[-1]
    for name in (".".join(parts[-2:]), leaf):
        if name in _LABELS:
            return _LABELS[name]
    ending = next((each for each in _ENDINGS if leaf.endswith(each)), "")
    words = leaf.removesuffix(ending).replace("_", " ")
    return words[:1].upper() + words[1:]


def section_label(path: str) -> str:
    """Of a section, as "sea.waves.1": "Waves 2"."""
    parts = path.split(".")
    name = ".".join(part for part in parts if not part.isdigit())
    number = f" {int(parts[-1]) + 1}" if parts[-1].isdigit() else ""
    return _SECTIONS.get(name, name) + number


def shown_unit(key: str, unit: str | None) -> str:
    """The unit in which a key is shown; empty for a plain number or a name."""
    leaf = key.rsplit(".", 1)[-1]
    if leaf in _SHOWN:
        return _SHOWN[leaf][0]
    return unit if unit and unit != "1" else ""


def shown(key: str, value: Any) -> str:
    """A value as it stands in a field: without unit, in the shown one."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list | tuple):
        return ", ".join(shown(key, each) for each in value)
    if not isinstance(value, int | float):
        return str(value)
    leaf = key.rsplit(".", 1)[-1]
    try:
        scaled = Decimal(repr(value)) / Decimal(_SHOWN[leaf][1]) if leaf in _SHOWN else Decimal(repr(value))
    except InvalidOperation:
        return repr(value)
    if not scaled.is_finite():
        return repr(value)
    text = f"{scaled.normalize():f}"
    return text if len(text) <= 20 else repr(float(scaled))


def read(key: str, text: str) -> Any:
    """What was typed into a field as the key's value in its own unit: a number where it is one, else the text itself,
    which the scene refuses where it wants a number; None for an empty field."""
    text = text.strip()
    if not text:
        return None
    if "," in text:
        return [read(key, part) for part in text.strip("[]").split(",")]
    leaf = key.rsplit(".", 1)[-1]
    try:
        parse_number(text)
        if leaf in _SHOWN:
            return float(Decimal(text) * Decimal(_SHOWN[leaf][1]))
        return int(text)
    except (InvalidOperation, ValueError):
        pass
    try:
        return parse_number(text)
    except ValueError:
        return text
