"""What a run leaves out of the radar, of the boat that carries it and of the things around it."""

from __future__ import annotations

import numpy as np

from ..settings import PlatformSettings
from . import radar_errors, sea_errors
from .basis import Basis
from .modelled import quantised
from .row import Row, metres_of_height

_TWO_WAYS_MORE = 16.0  # (1 + |ρ|)⁴ of a mirror that reflects all: a direct and a reflected way, there and back


def left_out_of_radar(basis: Basis) -> list[Row]:
    """Rows about the receiver and the scan."""
    radar, rows = basis.scene.radar, list[Row]()
    if radar.receiver.chain == "baseband":
        rows.append(_converter(basis))
    if radar.scan == "staring":
        kept = radar_errors.speckle_kept(basis.scene.scattering.decorrelation_time_s, radar.stare_s)
        still = sea_errors.still_sea_error(basis.waves, radar.stare_s)
        rows += [
            Row(
                "speckle from one map to the next",
                "each map of a staring antenna has speckle of its own",
                f"{kept:.2g} of correlation",
                "exp(−(τ/τc)²) of two pulses one map apart",
            ),
            Row(
                "the sea's own way within a map",
                f"it stands still for the {1e3 * radar.stare_s:g} ms of a map",
                metres_of_height(still),
                "√2 σ √(1 − ρ) over the map, against the sea half-way through",
            ),
        ]
    return rows


def _converter(basis: Basis) -> Row:
    bits = basis.scene.radar.receiver.adc_bits
    try:
        error = f"noise {quantised(basis):.2g} dB over the thermal noise"
    except ValueError:  # settings that nobody has asked for need not fit
        error = "not known: radar.receiver's intermediate frequency does not fit its rate"
    why = "ideal complex gates; radar.receiver.chain = 'digital' has the converter"
    source = f"q²/12 (Bennett 1948) of {bits} bits and the scene's full scale"
    return Row("analogue-to-digital conversion", why, error, source)


def left_out_of_boat_and_objects(basis: Basis) -> list[Row]:
    """Rows about what moves the antenna and what stands around it."""
    return [*_left_out_of_boat(basis), *_left_out_of_objects(basis)]


def _left_out_of_boat(basis: Basis) -> list[Row]:
    scene, platform, rows = basis.scene, basis.scene.platform, list[Row]()
    tilt = f"range × tilt along the look of a boat {platform.length_m:g} m long, {np.degrees(basis.boat_tilt):.2g}° rms"
    if platform == PlatformSettings():
        why = "it lies still; platform.motion = 'wave_following' lets it ride"
        error = f"{metres_of_height(basis.middle_m * basis.boat_tilt, basis.middle_m)}, were it unknown"
        rows.append(Row("the boat's own motion", why, error, tilt))
    elif platform.motion == "wave_following":
        why = "it follows the waves at once, as far as its size lets it: no resonance"
        error = f"not known; the tilt that it has is {np.degrees(basis.boat_tilt):.2g}° rms"
        rows.append(Row("the boat's dynamics", why, error, tilt))
    if platform.motion != "fixed" or platform.list_deg or platform.trim_deg:
        why = "the fan is laid on the mean sea; a crest is heard as if it lay off it by its height times the lean"
        off = basis.resolved.elevation_std * np.tan(basis.boat_tilt)
        error = f"{off:.2g} m rms of place"
        rows.append(Row("the waves' part in where a leaning beam meets the sea", why, error, "σ × tan of the lean"))
    sailed = platform.speed_m_s * scene.turns * scene.turn_duration_s
    if sailed > 0.5 * scene.radar.range_m[1]:
        why = f"they stay centred on the origin, and the boat sails {sailed:.3g} m off it"
        rows.append(Row("ground maps around the boat", why, f"{sailed:.3g} m of place at the end", "speed × time"))
    return rows


def _left_out_of_objects(basis: Basis) -> list[Row]:
    scene, rows = basis.scene, list[Row]()
    if scene.objects:
        nearest = min(float(np.linalg.norm(thing.position_m)) for thing in scene.objects)
        width = scene.radar.antenna.width_m
        behind = np.inf if nearest == 0.0 else width * max(0.0, basis.middle_m / nearest - 1.0)
        rows.append(
            Row(
                "the antennas' width",
                "an object hides what lies behind it from a point, be it as thin as a stay",
                f"{behind:.2g} m of half shadow at {basis.middle_m:.0f} m",
                f"an aperture of {width:g} m past the edge of an object {nearest:.2g} m away",
            )
        )
    if any(thing.rcs_dbsm is not None for thing in scene.objects):
        rows.append(
            Row(
                "echoes between objects and the sea",
                "an object echoes by its own cross-section alone",
                f"up to {10.0 * np.log10(_TWO_WAYS_MORE):.2g} dB of an object's echo",
                "two ways there and back over a mirror (Kerr 1951)",
            )
        )
    return rows
