"""Which keys matter for the switches that are chosen: the others are ignored by a run, and left out of the form."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Value = Callable[[str], Any]  # of a dotted key, the default where the scene leaves it out

_SINUSOIDAL = tuple(
    f"{motion}_{part}"
    for motion, unit in (("roll", "deg"), ("pitch", "deg"), ("yaw", "deg"), ("heave", "m"))
    for part in (unit, "period_s", "phase_deg")
)
_RULES: dict[str, tuple[tuple[str, tuple[Any, ...]], ...]] = {  # all conditions hold: a key has one of the values
    "sea.file": (("sea.model", ("recorded",)),),
    **{f"sea.{name}": (("sea.model", ("recorded",)),) for name in ("beyond", "start_s")},
    "scattering.nrcs_db": (("scattering.nrcs", ("constant",)),),
    "scattering.calibrated_to": (("scattering.nrcs", ("two_scale",)),),
    "scattering.breaking": (("scattering.nrcs", ("two_scale",)),),
    "scattering.sea_spikes": (("scattering.nrcs", ("two_scale",)),),
    "scattering.hydrodynamic_modulation": (("scattering.nrcs", ("two_scale",)),),
    "radar.chirp_bandwidth_hz": (("radar.waveform", ("chirp",)),),
    "radar.compression_window": (("radar.waveform", ("chirp",)),),
    "radar.rotation_rpm": (("radar.scan", ("turning",)),),
    "radar.stare_s": (("radar.scan", ("staring",)),),
    "radar.antenna.file": (("radar.antenna.pattern", ("file",)),),
    "radar.antenna.azimuth_beamwidth_deg": (("radar.antenna.pattern", ("slotted_waveguide", "gaussian", "isotropic")),),
    "radar.antenna.elevation_beamwidth_deg": (
        ("radar.antenna.pattern", ("slotted_waveguide", "gaussian", "isotropic")),
    ),
    "radar.antenna.feed": (("radar.antenna.pattern", ("slotted_waveguide",)),),
    "radar.antenna.design_frequency_hz": (
        ("radar.antenna.pattern", ("slotted_waveguide",)),
        ("radar.antenna.feed", ("end",)),
    ),
    "radar.antenna.guide_width_m": (
        ("radar.antenna.pattern", ("slotted_waveguide",)),
        ("radar.antenna.feed", ("end",)),
    ),
    **{
        f"radar.receiver.{name}": (("radar.receiver.chain", ("digital",)),)
        for name in ("if_hz", "adc_rate_hz", "adc_bits", "full_scale_dbm", "gain", "stc_exponent", "stc_range_m")
    },
    "radar.receiver.agc_headroom_db": (("radar.receiver.chain", ("digital",)), ("radar.receiver.gain", ("agc",))),
    **{f"platform.{name}": (("platform.motion", ("sinusoidal",)),) for name in _SINUSOIDAL},
    "platform.file": (("platform.motion", ("file",)),),
    "platform.length_m": (("platform.motion", ("wave_following",)),),
    "platform.beam_m": (("platform.motion", ("wave_following",)),),
    "platform.speed_m_s": (("platform.motion", ("fixed", "sinusoidal", "wave_following")),),
    "platform.list_deg": (("platform.motion", ("fixed", "sinusoidal", "wave_following")),),
    "platform.trim_deg": (("platform.motion", ("fixed", "sinusoidal", "wave_following")),),
    "retrieval.window_range_m": (("retrieval.estimator", ("sliding_plane",)),),
    "retrieval.window_azimuth_deg": (("retrieval.estimator", ("sliding_plane",)),),
    "retrieval.channel_gain_db": (("retrieval.channels", ("as_given",)),),
    "retrieval.channel_phase_deg": (("retrieval.channels", ("as_given",)),),
    "retrieval.pulse_pairs": (("radar.interferogram", ("alternating_pulse",)),),
    "prediction.vessel.length_m": (("prediction.vessel.shape", ("box",)),),
    "prediction.vessel.beam_m": (("prediction.vessel.shape", ("disc", "box")),),
    "prediction.vessel.draught_m": (("prediction.vessel.shape", ("disc", "box")),),
    "prediction.vessel.roll_period_s": (("prediction.vessel.shape", ("box",)),),
    **{f"prediction.vessel.{name}": (("prediction.vessel.shape", ("file",)),) for name in ("file", "body", "symmetry")},
    **{
        f"prediction.quiet.{name}": (("prediction.vessel.shape", ("raft", "disc", "box", "file")),)
        for name in ("heave_m", "roll_deg", "pitch_deg")
    },
}
_OF_WAVES: dict[str, tuple[str, tuple[Any, ...]]] = {  # of one wave system, by its own keys
    "spreading_exponent": ("spreading", ("cos2s",)),
    "inverse_wave_age": ("spreading", ("mitsuyasu", "hasselmann", "elfouhaily")),
}


def matters(key: str, value: Value) -> bool:
    """Whether a run heeds a key of a scene, given as `value` has the others."""
    if key.startswith("sea.waves."):
        above, leaf = key.rsplit(".", 1)
        switch = _OF_WAVES.get(leaf)
        if switch is None or value(f"{above}.spectrum") == "elfouhaily":
            return switch is None or leaf != "spreading_exponent" or value(f"{above}.spreading") == "cos2s"
        return value(f"{above}.{switch[0]}") in switch[1]
    return all(value(switch) in allowed for switch, allowed in _RULES.get(key, ()))


def switches() -> frozenset[str]:
    """The keys by which it is decided: where one changes, the form changes."""
    named = {switch for rules in _RULES.values() for switch, _ in rules}
    return frozenset(named | {"spectrum", *(switch for switch, _ in _OF_WAVES.values())})
