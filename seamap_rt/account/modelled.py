"""What a run models: how, and what leaving each part out would cost."""

from __future__ import annotations

import numpy as np

from ..conventions import db
from ..radar.array import antenna_array, common_squint_deg
from ..radar.digital import decimation
from ..radar.receiver import noise_power
from ..radar.scan import BEAMS_BEYOND, scanned_share
from ..radar.waveform import RangeResponse, blind_range_m
from ..scattering import MEAN_MODELS
from ..scene import Scene
from ..sea import Resolved
from ..settings import PlatformSettings, RadarSettings, ScatteringSettings
from . import light_errors, radar_errors, sea_errors
from .basis import Basis
from .row import NOTHING, Row, decibels, metres_of_height, share


def modelled_rows(basis: Basis) -> list[Row]:
    """Rows of what is modelled, in the order in which a turn meets them."""
    rows = [
        _sea(basis),
        _shadowing(basis),
        _scattering(basis),
        _speckle(basis),
        _motion(basis),
        _scan(basis),
        _mode(basis),
        _antennas(basis),
        _waveform(basis),
        _receiver(basis),
        _boat(basis),
    ]
    return rows + ([_objects(basis)] if basis.scene.objects else [])


# ------------------------------------------------------------------------------------------------ the sea


def _sea(basis: Basis) -> Row:
    error = metres_of_height(basis.resolved.elevation_std)
    return Row("sea", _sea_words(basis.scene, basis.resolved), error, "σ of the resolved spectrum")


def _sea_words(scene: Scene, resolved: Resolved) -> str:
    kind = {"linear": "linear", "choppy": "choppy (first-order Lagrangian)"}[scene.sea.model]
    current = f", on a current of {scene.sea.current_m_s:g} m/s" if scene.sea.current_m_s > 0.0 else ""
    return (
        f"{kind}, evolving{current}; waves longer than {2.0 * resolved.resolution_m:.3g} m resolved: "
        f"{resolved.variance_share:.2%} of the variance, {resolved.mean_square_slope_share:.0%} of the same "
        "spectra's mean square slope"
    )


def _scan(basis: Basis) -> Row:
    radar = basis.scene.radar
    if radar.scan == "staring":
        words = f"staring for {1e3 * radar.stare_s:g} ms a map, of the sea as it is half-way"
        return Row("scan", words, NOTHING, "a map's sea stands still")
    words = "azimuth is time: each column of the sea is meshed when the beam passes it"
    still = sea_errors.still_sea_error(basis.waves, scanned_share(radar) * basis.scene.turn_duration_s)
    return Row("scan", words, metres_of_height(still), "√2 σ √(1 − ρ) over the turn, against the sea half-way through")


def _motion(basis: Basis) -> Row:
    scene = basis.scene
    water = sea_errors.orbital_speed(basis.waves)
    own = 0.0 if scene.scattering.doppler == "orbital" else light_errors.bragg_speed(scene.radar.frequency_hz)
    cycles = radar_errors.doppler_cycles(scene.radar, float(np.hypot(water, own)))
    source = f"2vT/λ, v = {water:.2g} m/s rms of orbits" + (f" and {own:.2g} m/s of Bragg waves" if own else "")
    return Row("motion", _motion_words(scene.scattering), f"{cycles:.2g} cycles of phase in a dwell", source)


def _motion_words(scattering: ScatteringSettings) -> str:
    water = "each facet's phase follows its water particle while the beam dwells on it"
    if scattering.doppler == "orbital":
        return water
    extra = "Bragg waves of both directions run on it at their phase speed"
    if scattering.nrcs == "two_scale" and scattering.breaking:
        extra += ", breakers at theirs"
    return f"{water}; {extra}"


# -------------------------------------------------------------------------------------- light and scattering


def _shadowing(basis: Basis) -> Row:
    light = {
        "facets": "a shadow ray to each facet that faces the antenna, for each antenna, traced by Sionna RT/Mitsuba",
        "horizon": "running maximum of the elevation angle, float64",
        "paths": "a line-of-sight path to each facet, for each antenna, by Sionna RT's PathSolver",
    }[basis.scene.tracing.tracer]
    if basis.scene.tracing.diffraction == "knife_edge":
        light += "; beyond a crest, and close above it, the field of two knife edges"
    hidden = light_errors.shadowed_share(basis.scene.radar, 0.5 * basis.resolved.mean_square_slope)
    error = f"{share(hidden)} of the window would answer from the shade"
    return Row("shadowing", light, error, "Smith (1967), slopes of the resolved waves")


def _scattering(basis: Basis) -> Row:
    scattering = basis.scene.scattering
    words = f"{scattering.polarization}: {_scattering_words(scattering)}"
    if scattering.nrcs != "two_scale":
        level = float(db(light_errors.mean_level(basis.scene, basis.middle_m)))
        return Row("scattering", words, decibels(-level, f"the mean echo at {basis.middle_m:.0f} m"), "σ0 below 1")
    error = decibels(basis.facing.modulation_db, f"facets' own echo at {basis.middle_m:.0f} m")
    return Row("scattering", words, error, "rms over slopes that face the antenna and over winds, against the mean")


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


def _speckle(basis: Basis) -> Row:
    scattering = basis.scene.scattering
    words = f"complex Gaussian per facet, decorrelation time {1e3 * scattering.decorrelation_time_s:g} ms"
    looks = radar_errors.looks(basis.scene.radar, scattering.decorrelation_time_s)
    error = decibels(radar_errors.speckle_db(looks), "scatter of a gate's mean power over a dwell")
    return Row("speckle", words, error, f"1/√looks, {looks:.2g} looks a dwell")


# ---------------------------------------------------------------------------------------------- the radar


def _mode(basis: Basis) -> Row:
    radar, ways = basis.scene.radar, radar_errors.ways(basis.scene.radar)
    wrong = basis.resolved.elevation_std * (1.0 if ways == 2 else 0.5)
    source = f"σ × |p/p′ − 1|: read with p′ = {3 - ways} heights are {'doubled' if ways == 2 else 'halved'}"
    return Row("mode", _mode_words(radar, basis.scene.retrieval.paths), metres_of_height(wrong), source)


def _mode_words(radar: RadarSettings, paths: str) -> str:
    array = antenna_array(radar)
    words = f"{radar.transmit} transmitter, {radar.interferogram} interferogram: p = {radar_errors.ways(radar)}"
    if array.whole and radar.transmit == "switched" and paths == "best":
        words += "; maps take p = 2 from neighbouring pulses, of which p = 1 tells the cycle"
    return words


def _antennas(basis: Basis) -> Row:
    first = radar_errors.first_antenna(basis.scene.radar)
    aside = radar_errors.share_beyond(first, first.azimuth_beamwidth_deg, 1.0)
    error = f"{share(aside)} of the echo from more than a beam aside"
    return Row("antennas", _antenna_words(basis.scene.radar), error, "integral of the two-way azimuth pattern")


def _antenna_words(radar: RadarSettings) -> str:
    array, first = antenna_array(radar), radar_errors.first_antenna(radar)
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


def _waveform(basis: Basis) -> Row:
    cell = RangeResponse.of(basis.scene.radar).resolution_m
    slope = np.sqrt(0.5 * basis.resolved.mean_square_slope)
    error = metres_of_height(float(slope * cell / np.sqrt(12.0)))
    return Row("waveform", _waveform_words(basis.scene.radar), error, f"slope × {cell:.3g} m/√12, all within a gate")


def _waveform_words(radar: RadarSettings) -> str:
    if radar.waveform == "pulse":
        return f"rectangular pulse of {1e9 * radar.pulse_width_s:g} ns through a Gaussian filter"
    return (
        f"chirp of {1e6 * radar.pulse_width_s:g} µs over {1e-6 * radar.chirp_bandwidth_hz:g} MHz, matched filter with "
        f"{radar.compression_window} window; what comes before the transmitter is off is lost "
        f"(nearer than {blind_range_m(radar):.3g} m in part)"
    )


def _receiver(basis: Basis) -> Row:
    radar, middle = basis.scene.radar, basis.middle_m
    errors, source = list[str](), "Cramér–Rao bound over a dwell's pulses, textbook's echo"
    if radar.noise:
        snr = radar_errors.signal_to_noise(radar, light_errors.mean_level(basis.scene, middle), middle)
        errors.append(f"{metres_of_height(radar_errors.noise_height_error(radar, snr, middle), middle)} by noise")
        source += f" {float(db(snr)):.2g} dB over the noise"
    if radar.receiver.chain == "digital":
        errors.append(f"converter's noise {quantised(basis):.2g} dB over the thermal noise")
        source += "; q²/12 (Bennett 1948)"
    return Row("receiver", _receiver_words(radar), "; ".join(errors) or NOTHING, source if errors else "")


def quantised(basis: Basis) -> float:
    """The converter's noise over the thermal one, dB; automatic gain takes the near gate's echo for the strongest."""
    radar = basis.scene.radar
    near = float(light_errors.window(radar)[0])
    strongest = radar_errors.signal_to_noise(radar, light_errors.mean_level(basis.scene, near), near)
    return radar_errors.quantisation_db(radar, radar_errors.full_scale_w(radar, strongest * noise_power(radar)))


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


# ------------------------------------------------------------------------------------- the boat, and things


def _boat(basis: Basis) -> Row:
    words = _boat_words(basis.scene.platform)
    if basis.scene.platform == PlatformSettings():
        return Row("boat", words, NOTHING)
    error = metres_of_height(basis.middle_m * basis.boat_tilt, basis.middle_m)
    return Row("boat", words, error, f"range × tilt along the look, {np.degrees(basis.boat_tilt):.2g}° rms")


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


def _objects(basis: Basis) -> Row:
    scene = basis.scene
    echoing = [thing for thing in scene.objects if thing.rcs_dbsm is not None]
    words = f"{len(scene.objects)} hide the sea behind them, {len(echoing)} of them echo themselves"
    if not echoing:
        return Row("objects", words, "the sea behind them would answer")
    near, far = light_errors.window(scene.radar)[[0, -1]]
    over = []
    for thing in echoing:
        place = float(np.clip(np.linalg.norm(thing.position_m), near, far))
        level = light_errors.mean_level(scene, place)
        over.append(radar_errors.object_over_sea_db(scene.radar, float(thing.rcs_dbsm or 0.0), level, place))
    return Row("objects", words, f"{max(over):.2g} dB over the sea in its cell, at most", "rcs/(σ0 A) of each")
