"""What a run modelled, and what it left out and why: the words of `metrics.json` and of the report."""

from __future__ import annotations

import numpy as np

from .conventions import EARTH_RADIUS, db
from .radar.array import antenna_array, common_squint_deg
from .radar.digital import decimation
from .radar.scan import BEAMS_BEYOND
from .radar.waveform import blind_range_m
from .scattering import MEAN_MODELS, sea_state_from_wind
from .scene import Scene
from .sea import Resolved
from .settings import PlatformSettings, RadarSettings, ScatteringSettings

_BREAKING_STEEPNESS = 0.06  # Hs over the peak's length
_CARRIED = 0.97
_BREAKING_DEPTH = 0.6  # Hs over the depth


def modelled(scene: Scene, resolved: Resolved) -> list[dict[str, str]]:
    """Rows {what, why} of what was modelled, and how."""
    radar, scattering = scene.radar, scene.scattering
    light = {
        "facets": "a shadow ray to each facet that faces the antenna, for each antenna, traced by Sionna RT/Mitsuba",
        "horizon": "running maximum of the elevation angle, float64",
    }[scene.tracing.tracer]
    if scene.tracing.diffraction == "knife_edge":
        light += "; beyond a crest, and close above it, the field of two knife edges"
    rows = [
        ("sea", _sea_words(scene, resolved)),
        ("shadowing", light),
        ("scattering", f"{scattering.polarization}: {_scattering_words(scattering)}"),
        ("speckle", f"complex Gaussian per facet, decorrelation time {1e3 * scattering.decorrelation_time_s:g} ms"),
        ("motion", _motion_words(scattering)),
        ("scan", _scan_words(scene)),
        ("mode", _mode_words(radar, scene.retrieval.paths)),
        ("antennas", _antenna_words(radar)),
        ("waveform", _waveform_words(radar)),
        ("receiver", _receiver_words(radar)),
        ("boat", _boat_words(scene.platform)),
    ]
    if scene.objects:
        echoing = sum(thing.rcs_dbsm is not None for thing in scene.objects)
        rows.append(("objects", f"{len(scene.objects)} hide the sea behind them, {echoing} of them echo themselves"))
    return [{"what": what, "why": why} for what, why in rows]


def _scattering_words(scattering: ScatteringSettings) -> str:
    if scattering.nrcs == "constant":
        return f"{scattering.nrcs_db:g} dB per horizontal area, shadowing on top"
    paper = MEAN_MODELS[scattering.mean_model].paper if scattering.mean_model else ""
    if scattering.nrcs != "two_scale":
        return f"the mean of {paper} on every lit facet, shadowing counted once"
    words = ["Bragg waves and mirrors on each facet, tilted by it and by the wind's waves that the mesh does not carry"]
    if scattering.hydrodynamic_modulation:
        words.append("their height modulated by the strain of the resolved waves")
    if scattering.breaking:
        words.append("breakers, most of them where the resolved waves converge")
    words.append(f"mean calibrated to {paper}, shadowing counted once" if paper else "theory's own mean")
    return "; ".join(words)


def _motion_words(scattering: ScatteringSettings) -> str:
    water = "each facet's phase follows its water particle while the beam dwells on it"
    if scattering.doppler == "orbital":
        return water
    extra = "Bragg waves of both directions run on it at their phase speed"
    if scattering.nrcs == "two_scale" and scattering.breaking:
        extra += ", breakers at theirs"
    return f"{water}; {extra}"


def _scan_words(scene: Scene) -> str:
    if scene.radar.scan == "staring":
        return f"staring for {1e3 * scene.radar.stare_s:g} ms a map, of the sea as it is half-way"
    return "azimuth is time: each column of the sea is meshed when the beam passes it"


def _mode_words(radar: RadarSettings, paths: str) -> str:
    array = antenna_array(radar)
    factor = 2 if not array.whole and radar.transmit == "switched" else 1
    words = f"{radar.transmit} transmitter, {radar.interferogram} interferogram: p = {factor}"
    if array.whole and radar.transmit == "switched" and paths == "best":
        words += "; maps take p = 2 from neighbouring pulses, of which p = 1 tells the cycle"
    return words


def _antenna_words(radar: RadarSettings) -> str:
    array = antenna_array(radar)
    first = array.elements[array.receivers[0]].antenna
    words = [
        f"{len(array.elements)}, {radar.antenna.pattern}, with sidelobes as far as ±{BEAMS_BEYOND:g} beams",
        f"{first.azimuth_beamwidth_deg:.3g}° × {first.elevation_beamwidth_deg:.3g}°, {float(db(first.gain)):.3g} dBi",
    ]
    if common_squint_deg(radar):
        words.append(f"squint {common_squint_deg(radar):.3g}°, known")
    if any(element.channel != 1.0 for element in array.elements):
        words.append("channels that are not alike, unknown to the retrieval")
    if (array.offsets != array.known_offsets).any():
        words.append("antennas that stand elsewhere than the retrieval thinks")
    return "; ".join(words)


def _waveform_words(radar: RadarSettings) -> str:
    if radar.waveform == "pulse":
        return f"rectangular pulse of {1e9 * radar.pulse_width_s:g} ns through a Gaussian filter"
    return (
        f"chirp of {1e6 * radar.pulse_width_s:g} µs over {1e-6 * radar.chirp_bandwidth_hz:g} MHz, matched filter with "
        f"{radar.compression_window} window; what comes before the transmitter is off is lost "
        f"(nearer than {blind_range_m(radar):.3g} m in part)"
    )


def _receiver_words(radar: RadarSettings) -> str:
    noise = "thermal noise" if radar.noise else "no noise"
    receiver = radar.receiver
    if receiver.chain == "baseband":
        return f"ideal complex gates, {noise}"
    gain = "automatic gain" if receiver.gain == "agc" else f"full scale {receiver.full_scale_dbm:g} dBm"
    return (
        f"{noise}; {1e-6 * receiver.if_hz:g} MHz sampled at {1e-6 * receiver.adc_rate_hz:g} MS/s with "
        f"{receiver.adc_bits} bits, {gain}, saturation, digital down-conversion and decimation by {decimation(radar)}"
    )


def _boat_words(platform: PlatformSettings) -> str:
    words = {
        "fixed": "steady" if platform.speed_m_s or platform.list_deg or platform.trim_deg else "at rest",
        "sinusoidal": "rolls, pitches, yaws and heaves in sines",
        "wave_following": f"{platform.length_m:g} m long, goes with the waves that the radar sees, without resonance",
        "file": "moves as recorded",
    }[platform.motion]
    if platform.speed_m_s:
        words += f", {platform.speed_m_s:g} m/s"
    sensed = platform.sensors
    return words + ("; sensors perfect" if sensed == type(sensed)() else "; its sensors err")


def _sea_words(scene: Scene, resolved: Resolved) -> str:
    kind = {"linear": "linear", "choppy": "choppy (first-order Lagrangian)"}[scene.sea.model]
    current = f", on a current of {scene.sea.current_m_s:g} m/s" if scene.sea.current_m_s > 0.0 else ""
    return (
        f"{kind}, evolving{current}; waves longer than {2.0 * resolved.resolution_m:.3g} m resolved: "
        f"{resolved.variance_share:.2%} of the variance, {resolved.mean_square_slope_share:.0%} of the same "
        "spectra's mean square slope"
    )


def left_out(scene: Scene, resolved: Resolved) -> list[dict[str, str]]:
    """Rows {what, why} of what was not, and why or by which key it would be."""
    beam = np.radians(antenna_array(scene.radar).narrowest_beam_deg)
    facet_width = scene.radar.range_m[1] * beam / scene.detail.columns_per_beam
    rows = [
        ("multiple scattering", "one bounce; the second is not traced"),
        (
            "slopes of resolved waves that the mesh is too coarse for",
            f"its columns are {facet_width:.2g} m wide at the far gate, its rungs {scene.detail.facet_m:g} m apart; "
            f"the shortest resolved waves are {2.0 * resolved.resolution_m:.2g} m long",
        ),
        (
            "Earth curvature",
            f"flat Earth: the drop at {scene.radar.range_m[1]:g} m is "
            f"{scene.radar.range_m[1] ** 2 / (2.0 * 4.0 / 3.0 * EARTH_RADIUS):.2g} m",
        ),
    ]
    rows += _left_out_of_the_radar(scene)
    rows += _left_out_of_the_scattering(scene)
    rows += _left_out_of_the_sea(scene, resolved)
    return [{"what": what, "why": why} for what, why in rows]


def _left_out_of_the_radar(scene: Scene) -> list[tuple[str, str]]:
    radar, platform, rows = scene.radar, scene.platform, list[tuple[str, str]]()
    if platform == PlatformSettings():
        rows.append(("the boat's own motion", "it lies still; platform.motion = 'wave_following' lets it ride"))
    elif platform.motion == "wave_following":
        rows.append(("the boat's dynamics", "it follows the waves at once, as far as its size lets it: no resonance"))
    if radar.receiver.chain == "baseband":
        rows.append(
            (
                "analogue-to-digital conversion",
                "ideal complex gates; radar.receiver.chain = 'digital' has the converter",
            )
        )
    if radar.scan == "staring":
        rows.append(("speckle from one map to the next", "each map of a staring antenna has speckle of its own"))
    if platform.motion != "fixed" or platform.list_deg or platform.trim_deg:
        rows.append(
            (
                "the waves' part in where a leaning beam meets the sea",
                "the fan is laid on the mean sea; a crest is heard as if it lay off it by its height times the lean",
            )
        )
    sailed = platform.speed_m_s * scene.turns * scene.turn_duration_s
    if sailed > 0.5 * radar.range_m[1]:
        rows.append(
            (
                "ground maps around the boat",
                f"they stay centred on the origin, and the boat sails {sailed:.3g} m off it",
            )
        )
    if scene.objects:
        rows.append(
            ("the antennas' width", "an object hides what lies behind it from a point, be it as thin as a stay")
        )
    if any(thing.rcs_dbsm is not None for thing in scene.objects):
        rows.append(("echoes between objects and the sea", "an object echoes by its own cross-section alone"))
    return rows


def _left_out_of_the_scattering(scene: Scene) -> list[tuple[str, str]]:
    scattering, rows = scene.scattering, list[tuple[str, str]]()
    if scene.tracing.diffraction == "none":
        rows.append(
            (
                "diffraction at shadow edges",
                "geometric shadows; an edge blurs by about 0.5 m at X band; tracing.diffraction = 'knife_edge'",
            )
        )
    if scattering.doppler == "orbital":
        rows.append(("the scatterers' own velocity", "facets move with the water only; scattering.doppler = 'full'"))
    if scattering.nrcs == "two_scale":
        rows.append(("shadows of waves that are not resolved", "the mesh does not carry them; a tilt may turn away"))
        if scattering.breaking:
            rows.append(("a breaker's life", "breakers are a share of each facet, not bursts that grow and fade"))
        else:
            rows.append(("breakers", "scattering.breaking = false: HH owes its mean to the calibration"))
        if not scattering.hydrodynamic_modulation:
            rows.append(("hydrodynamic modulation", "scattering.hydrodynamic_modulation = false: tilt alone modulates"))
    else:
        rows.append(
            (
                "tilt, strain and breakers",
                f"scattering.nrcs = '{scattering.nrcs}' gives every facet that is seen its mean; 'two_scale' has them, "
                "and only it asks for calibrated_to, breaking, hydrodynamic_modulation and inverse_wave_age",
            )
        )
    if scene.tracing.diffraction != "none":
        rows.append(
            (
                "what diffraction does to heights",
                "a shadow answers with its crest's height, and the fringes above a crest pull heights beside it down; "
                "the stated error knows neither",
            )
        )
    if scattering.mean_model is not None:
        model = MEAN_MODELS[scattering.mean_model]
        if scattering.extrapolate:
            rows.append(
                (
                    "the clutter model's own range",
                    f"scattering.extrapolate = true: {model.paper} holds for sea states {model.sea_state[0]:g} to "
                    f"{model.sea_state[1]:g} and {1e-9 * model.frequency_hz[0]:g} to "
                    f"{1e-9 * model.frequency_hz[1]:g} GHz; this scene is sea state "
                    f"{float(sea_state_from_wind(scattering.wind_speed_m_s)):.2g} at "
                    f"{1e-9 * scene.radar.frequency_hz:g} GHz",
                )
            )
        if not model.knows_wind_direction:
            rows.append(
                (
                    "wind-direction contrast of the mean echo",
                    f"{model.paper} is an average over directions; git, tsc and hybrid know them",
                )
            )
        low, high = model.grazing_deg
        rows.append(
            (f"the mean outside {low:g}–{high:g}° grazing", "facets beyond take the value at the edge of its range")
        )
    return rows


def _left_out_of_the_sea(scene: Scene, resolved: Resolved) -> list[tuple[str, str]]:
    rows: list[tuple[str, str]] = []
    if scene.sea.model == "linear":
        rows.append(("sharper crests", "waves are linear; sea.model = 'choppy' sharpens them"))
    else:
        rows.append(
            (
                "skewness of the elevation",
                "0 at the first Lagrangian order; a narrow-banded second-order sea of this height and peak would have "
                f"{resolved.skewness_stokes:.2g}",
            )
        )
    if scene.detail.facet_m > resolved.resolution_m:
        rows.append(
            (
                f"slopes of resolved waves shorter than {2.0 * scene.detail.facet_m:g} m along the look",
                f"facets are {scene.detail.facet_m:g} m apart, the waves' grid {resolved.resolution_m:.3g} m: neither "
                "the mesh nor the scattering has all of them; lower tracing.facet_m or coarsen sea.resolution_m",
            )
        )
    if resolved.carried_share < _CARRIED:
        rows.append(
            (
                "the longest waves' place in the spectrum",
                f"the periodic patch samples {resolved.carried_share:.0%} of a system's variance; the rest is spread "
                "over its other waves; raise sea.extent_m",
            )
        )
    if resolved.significant_steepness > _BREAKING_STEEPNESS:
        rows.append(
            (
                "breaking, which this sea would do",
                f"its significant height over the length of its peak is {resolved.significant_steepness:.2g}; real "
                f"seas stay below about {_BREAKING_STEEPNESS:g}",
            )
        )
    if 4.0 * resolved.elevation_std > _BREAKING_DEPTH * scene.sea.depth_m:
        rows.append(
            (
                "breaking on the bed, which this sea would do",
                f"its significant height is {4.0 * resolved.elevation_std / scene.sea.depth_m:.2g} of the depth; real "
                f"seas stay below about {_BREAKING_DEPTH:g}, and troughs may reach below the bed",
            )
        )
    return rows
