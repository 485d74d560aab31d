"""What people call the keys of a scene: labels and units with their factors; and which keys a run heeds."""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal, InvalidOperation
from typing import Any, NamedTuple, get_args

from pydantic import BaseModel

from ..io.text import parse_number
from ..scene import Scene
from ..settings import Meaning, meaning_of

_ENDINGS = ("_m_s", "_dbsm", "_dbm", "_dbi", "_deg", "_rpm", "_psu", "_hz", "_db", "_m", "_s", "_w", "_c")

_LABELS = {  # what follows a bar stands in the form alone
    "adc_bits": "Converter bits",
    "adc_rate_hz": "Converter rate",
    "agc_headroom_db": "Automatic gain headroom",
    "azimuth_beamwidth_deg": "Beam width, azimuth",
    "bandwidth_hz": "Bandwidth",
    "baseline_m": "Baseline| between the antennas",
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
    "frequency_hz": "Frequency",
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
    "peak_period_s": "Peak period| Tp",
    "polarization": "Polarization",
    "prf_hz": "Pulse repetition",
    "radar.height_m": "Antenna height| above the sea",
    "range_m": "Range window",
    "range_sampling_m": "Gate spacing",
    "rcs_dbsm": "Radar cross-section",
    "resolution_m": "Spacing of the resolved waves",
    "significant_wave_height_m": "Significant wave height| Hs",
    "spreading_exponent": "Spreading exponent s",
    "stc_exponent": "Sensitivity-time exponent",
    "stc_range_m": "Sensitivity-time range",
    "tracer": "Tracer",
    "transmit": "Transmitters",
    "transmit_power_w": "Transmit power",
    "trim_deg": "Trim, bow up",
    "velocity_z_m_s": "Water speed upwards stays below",
    "quiet.elevation_m": "Water height stays below",
    "quiet.heave_m": "Heave stays below",
    "quiet.roll_deg": "Roll stays below",
    "quiet.pitch_deg": "Pitch stays below",
    "quiet.duration_s": "Window lasts",
    "wave_from_deg": "Waves come from",
    "wind_speed_m_s": "Wind speed",
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


class KeyWords(NamedTuple):
    """name: lower case; unit: empty where there is none; meaning: a sentence, empty where the schema has none."""

    name: str
    unit: str
    meaning: str

    @property
    def label(self) -> str:
        """For an axis or the head of a column."""
        return f"{self.name[0].upper()}{self.name[1:]}" + (f" ({self.unit})" if self.unit else "")

    def value(self, value: Any) -> str:
        """A value with its unit."""
        text = f"{value:g}" if _is_number(value) else str(value)
        return f"{text} {self.unit}" if self.unit and _is_number(value) else text


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def words_of(key: str) -> KeyWords:
    """Of any key of a scene, as `radar.height_m` or `sea.waves.0.hs_m`."""
    meaning = _meaning(Scene, key.split("."))
    unit = meaning.unit if meaning is not None and meaning.unit not in (None, "1") else ""
    label = label_of(key, alone=True)
    return KeyWords(label[:1].lower() + label[1:], unit or "", meaning.text if meaning else "")


def label_of(key: str, alone: bool = False) -> str:
    """Of a key, as "radar.height_m" or "sea.waves.0.peak_period_s": words without unit. alone: not under its section's
    title."""
    *sections, leaf = (part for part in key.split(".") if not part.isdigit())
    for name in (".".join([*sections[-1:], leaf]), leaf):
        if name in _LABELS:
            return _LABELS[name].split("|")[0] if alone else _LABELS[name].replace("|", "")
    ending = next((each for each in _ENDINGS if leaf.endswith(each)), "")
    words = " ".join([*(sections[-1:] if alone else ()), leaf.removesuffix(ending)]).replace("_", " ")
    return words[:1].upper() + words[1:]


def section_label(path: str) -> str:
    """Of a section, as "sea.waves.1": "Waves 2"."""
    parts = path.split(".")
    name = ".".join(part for part in parts if not part.isdigit())
    number = f" {int(parts[-1]) + 1}" if parts[-1].isdigit() else ""
    return _SECTIONS.get(name, name) + number


def shown_unit(key: str, unit: str | None) -> str:
    """The unit in which a key is shown; empty for a plain number or a name."""
    return _SHOWN.get(key.rsplit(".", 1)[-1], (unit if unit and unit != "1" else "", ""))[0]


def shown_value(key: str, value: Any) -> str:
    """A value as it stands in a field: without unit, in the shown one."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list | tuple):
        return ", ".join(shown_value(key, each) for each in value)
    if not isinstance(value, int | float):
        return str(value)
    scaled = Decimal(str(value)) / _factor(key)
    if not scaled.is_finite():
        return repr(value)
    text = f"{scaled.normalize():f}"
    return text if len(text) <= 20 else repr(float(scaled))


def read_value(key: str, text: str) -> Any:
    """What was typed into a field as the key's value in its own unit: a number where it is one, else the text itself,
    which the scene refuses where it wants a number; None for an empty field."""
    text = text.strip()
    if not text:
        return None
    if "," in text:
        return [read_value(key, part) for part in text.strip("[]").split(",")]
    try:
        number = parse_number(text)
    except ValueError:
        return text
    try:
        return float(Decimal(text) * _factor(key)) if _factor(key) != 1 else int(text)
    except (InvalidOperation, ValueError):
        return number


def _factor(key: str) -> Decimal:
    """How many of its own unit a key's shown one is."""
    return Decimal(_SHOWN.get(key.rsplit(".", 1)[-1], ("", "1"))[1])


def _meaning(model: type[BaseModel], path: list[str]) -> Meaning | None:
    """What the schema says of a key; a list's number is passed over, of a union the first that has the key."""
    name, *rest = path
    if name.isdigit():
        return _meaning(model, rest) if rest else None
    field = model.model_fields.get(name)
    if field is None:
        return None
    if not rest:
        return meaning_of(field)
    return next((found for each in _models(field.annotation) if (found := _meaning(each, rest)) is not None), None)


def _models(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for part in get_args(annotation) for model in _models(part)]


# ------------------------------------------------------------------------------------------------- what a run heeds

_SINUSOIDAL = " ".join(
    f"{motion}_{part}"
    for motion, unit in (("roll", "deg"), ("pitch", "deg"), ("yaw", "deg"), ("heave", "m"))
    for part in (unit, "period_s", "phase_deg")
)
_PATTERN, _SLOTTED = "radar.antenna.pattern", "slotted_waveguide"
_TWO_SCALE = "calibrated_to breaking sea_spikes texture hydrodynamic_modulation"
_RULES = (  # section, its keys, and what must hold for a run to heed them: values of other keys
    ("sea", "file beyond start_s", {"sea.model": "recorded"}),
    ("scattering", "nrcs_db", {"scattering.nrcs": "constant"}),
    ("scattering", _TWO_SCALE, {"scattering.nrcs": "two_scale"}),
    ("radar", "chirp_bandwidth_hz compression_window", {"radar.waveform": "chirp"}),
    ("radar", "rotation_rpm", {"radar.scan": "turning"}),
    ("radar", "stare_s", {"radar.scan": "staring"}),
    ("radar.antenna", "file", {_PATTERN: "file"}),
    ("radar.antenna", "azimuth_beamwidth_deg elevation_beamwidth_deg", {_PATTERN: f"{_SLOTTED} gaussian isotropic"}),
    ("radar.antenna", "feed", {_PATTERN: _SLOTTED}),
    ("radar.antenna", "design_frequency_hz guide_width_m", {_PATTERN: _SLOTTED, "radar.antenna.feed": "end"}),
    ("radar.receiver", "if_hz adc_rate_hz gain", {"radar.receiver.chain": "digital"}),
    ("radar.receiver", "adc_bits full_scale_dbm stc_exponent stc_range_m", {"radar.receiver.chain": "digital video"}),
    ("radar.receiver", "knee_db video_bandwidth_hz video_pulses", {"radar.receiver.chain": "video"}),
    ("radar.receiver", "agc_headroom_db", {"radar.receiver.chain": "digital", "radar.receiver.gain": "agc"}),
    ("platform", _SINUSOIDAL, {"platform.motion": "sinusoidal"}),
    ("platform", "file", {"platform.motion": "file"}),
    ("platform", "length_m beam_m", {"platform.motion": "wave_following"}),
    ("platform", "speed_m_s list_deg trim_deg", {"platform.motion": "fixed sinusoidal wave_following"}),
    ("retrieval", "window_range_m window_azimuth_deg", {"retrieval.estimator": "sliding_plane"}),
    ("retrieval", "channel_gain_db channel_phase_deg", {"retrieval.channels": "as_given"}),
    ("retrieval", "pulse_pairs", {"radar.interferogram": "alternating_pulse"}),
    ("prediction.vessel", "length_m roll_period_s", {"prediction.vessel.shape": "box"}),
    ("prediction.vessel", "beam_m draught_m", {"prediction.vessel.shape": "disc box"}),
    ("prediction.vessel", "file body symmetry", {"prediction.vessel.shape": "file"}),
    ("prediction.quiet", "heave_m roll_deg pitch_deg", {"prediction.vessel.shape": "raft disc box file"}),
)
HEEDED = {f"{section}.{key}": rule for section, keys, rule in _RULES for key in keys.split()}


def matters(key: str, value: Callable[[str], Any]) -> bool:
    """Whether a run heeds a key of a scene. value: of a dotted key, the default where the scene leaves it out."""
    if key.startswith("sea.waves."):
        above, leaf = key.rsplit(".", 1)
        spreading, spectrum = (f"{above}.{name}" for name in ("spreading", "spectrum"))
        if leaf == "spreading_exponent":
            return value(spreading) == "cos2s"
        by_age = ("mitsuyasu", "hasselmann", "elfouhaily")
        return leaf != "inverse_wave_age" or value(spectrum) == "elfouhaily" or value(spreading) in by_age
    return all(value(switch) in allowed.split() for switch, allowed in HEEDED.get(key, {}).items())


def switches() -> frozenset[str]:
    """The keys by which it is decided: where one changes, the form changes."""
    return frozenset({"spectrum", "spreading", *(switch for _, _, rule in _RULES for switch in rule)})
