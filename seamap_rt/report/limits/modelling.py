"""What a run models, how, and the error of leaving it out."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from ...conventions import db
from ...interferometry.phase.interferogram import LASTING
from ...radar import link, precision
from ...radar.array import antenna_array, common_squint_deg
from ...radar.digital import decimation, full_scale_w, quantisation_db
from ...radar.receiver import measures_phase, noise_power, pulse_coherence, transmit_phase_error
from ...radar.scan import scanned_share
from ...radar.waveform import RangeResponse, blind_range_m
from ...scattering import MEAN_MODELS
from ...scattering.bragg import bragg_speed
from ...scattering.sea_spikes import sea_spikes
from ...settings import PlatformSettings, ScatteringSettings
from .case import Case
from .rows import (
    BENT,
    BURSTS,
    CYCLES,
    HEIGHT,
    MEAN_ECHO,
    OWN_ECHO,
    PATTERN,
    STILL,
    TILT,
    TILTS,
    TWO_SCALE,
    UNRESOLVED,
    Row,
    row,
)


def _sea(case: Case) -> Iterator[Row]:
    sea, tracing, radar, resolved = case.scene.sea, case.scene.tracing, case.scene.radar, case.resolved
    shares = f"{resolved.variance_share:.2%} of the variance, {resolved.mean_square_slope_share:.0%} of the slopes'"
    says = f"{sea.model}, evolving; waves longer than {2.0 * resolved.resolution_m:.3g} m resolved: {shares}"
    if resolved.record_start is not None:
        says += f"; time 0 of the run is {resolved.record_start} of sea.file"
    yield row("sea", resolved.elevation_std, HEIGHT, "σ of the resolved spectrum", says)
    still = case.waves.still_sea_error(scanned_share(radar) * case.scene.turn_duration_s)
    says = "azimuth is time: each column of the sea is meshed when the beam passes it"
    if radar.scan == "staring":
        still, says = 0.0, f"staring for {1e3 * radar.stare_s:g} ms a map, of the sea as it is half-way"
    yield row("scan", still, HEIGHT, STILL, says)

    says = {
        "facets": "a shadow ray to each facet that faces the antenna, for each antenna, traced by Sionna RT/Mitsuba",
        "horizon": "running maximum of the elevation angle, float64",
        "paths": "a line-of-sight path to each facet, for each antenna, by Sionna RT's PathSolver",
    }[tracing.tracer]
    says += "; near a crest's shadow the field of two knife edges" if tracing.diffraction == "knife_edge" else ""
    hidden = 100.0 * link.shadowed_share(radar, case.resolved.look_slope_variance)
    error, source = "% of the window would answer from the shade", "Smith (1967), slopes of the resolved waves"
    yield row("shadowing", hidden, error, source, says)
    if tracing.unresolved_shadowing != "none":
        says = "of each lit facet the share that its own grazing angle leaves in sight, for both antennas alike"
        hidden, source = case.hidden_by_tilts, TILTS
        if tracing.unresolved_shadowing == "fresnel":
            says += (
                f"; what is hidden keeps {case.kept_by_shadows:.0%} of its echo in {case.scene.scattering.polarization}"
            )
            hidden, source = hidden * (1.0 - case.kept_by_shadows), BENT
        yield row(UNRESOLVED, hidden, error, source, says)


def _echoes(case: Case) -> Iterator[Row]:
    radar, scattering = case.scene.radar, case.scene.scattering
    theory, model = scattering.nrcs == "two_scale", MEAN_MODELS.get(scattering.mean_model or "")
    paper = model.paper if model else ""
    around = "" if model is None or model.knows_wind_direction else " over azimuth"
    says = {
        f"{scattering.nrcs_db:g} dB per horizontal area, shadowing on top": scattering.nrcs == "constant",
        f"the mean of {paper} on every lit facet, shadowing counted once": not theory and model is not None,
        "Bragg waves and mirrors on each facet, tilted by it and by the waves that the mesh does not carry": theory,
        "their height modulated by the strain of the resolved waves": theory and scattering.hydrodynamic_modulation,
        "breakers, most of them where the resolved waves converge": theory and scattering.breaking,
        "each a burst that runs with its wave, grows and fades": _spikes(scattering),
        f"mean{around} calibrated to {paper}, shadowing counted once": theory and model is not None,
        "theory's own mean": theory and model is None,
    }
    if theory:
        level, error, source = case.facing.modulation_db, OWN_ECHO, TWO_SCALE
    else:
        level, error, source = -float(db(case.level(case.middle_m))), MEAN_ECHO, f"σ0 of {scattering.nrcs} below 1"
    yield row("scattering", level, f"{error} {case.at}", source, f"{scattering.polarization}: {_said(says)}")

    if _spikes(scattering):
        spikes = sea_spikes(scattering.wind_speed_m_s, scattering.inverse_wave_age, radar.frequency_hz)
        own = math.inf if spikes is None else float(spikes.shape(case.cell_m2))
        says = f"a Poisson process of breakers, whose texture on a level sea has the shape {own:.2g} {case.at}"
        yield row("sea spikes", case.clutter_shape, f"{BURSTS} {case.at}", "Watts & Wicks (1990)", says)

    time = scattering.decorrelation_time_s
    looks, says = precision.looks(radar, time), f"complex Gaussian per facet, decorrelation time {1e3 * time:g} ms"
    error, source = "dB of scatter of a gate's mean power over a dwell", f"1/√looks, {looks:.2g} looks a dwell"
    yield row("speckle", precision.speckle_db(looks), error, source, says)

    water, bragg, says = case.waves.orbital_speed(), 0.0, "each facet's phase follows its water particle"
    source = f"2vT/λ, v = {water:.2g} m/s rms of orbits"
    if scattering.doppler != "orbital":
        bragg = bragg_speed(radar.frequency_hz)
        source += f" and {bragg:.2g} m/s of Bragg waves"
        says += f", with Bragg waves{' and breakers' if theory and scattering.breaking else ''} at their own speeds"
    yield row("motion", precision.doppler_cycles(radar, math.hypot(water, bragg)), CYCLES, source, says)


def _radar(case: Case) -> Iterator[Row]:
    radar, array, sigma = case.scene.radar, antenna_array(case.scene.radar), case.resolved.elevation_std
    paths, first, squint = array.phase_paths, array.first_antenna, common_squint_deg(radar)
    best = array.whole and radar.transmit == "switched" and case.scene.retrieval.paths == "best"
    best = best and pulse_coherence(radar) >= LASTING
    says = {
        f"{radar.transmit} transmitter, {radar.interferogram} interferogram: p = {paths}": True,
        "maps take p = 2 from neighbouring pulses, of which p = 1 tells the cycle": best,
    }
    wrong, read = (sigma, "doubled") if paths == 2 else (0.5 * sigma, "halved")
    yield row("mode", wrong, HEIGHT, f"σ × |p/p′ − 1|: read with p′ = {3 - paths} heights are {read}", _said(says))
    if radar.transmitter == "magnetron":
        yield _magnetron(case, pairs=best or not array.whole)

    beam = f"a beam of {first.azimuth_beamwidth_deg:.3g}° × {first.elevation_beamwidth_deg:.3g}°"
    says = {
        f"{len(array.elements)}, {radar.antenna.pattern}, {beam}, {float(db(first.gain)):.3g} dBi": True,
        f"squint {squint:.3g}°, known": squint != 0.0,
        "channels that are not alike, unknown to the retrieval": any(each.channel != 1.0 for each in array.elements),
        "antennas stand elsewhere than the retrieval assumes": bool((array.offsets != array.known_offsets).any()),
    }
    aside = 100.0 * first.share_beyond(1.0)
    yield row("antennas", aside, "% of the echo from more than a beam aside", PATTERN, _said(says))

    cell, says = RangeResponse.of(radar).resolution_m, f"{radar.waveform} of {1e9 * radar.pulse_width_s:g} ns"
    matched = f"; its echoes from nearer than {blind_range_m(radar):.3g} m are lost in part"
    says += matched if radar.waveform == "chirp" else " through a Gaussian filter"
    blur = math.sqrt(case.resolved.mean_square_slope / 24.0) * cell
    yield row("waveform", blur, HEIGHT, f"slope × {cell:.3g} m/√12, all within a gate", says)

    noise, error, source = 0.0, HEIGHT, "Cramér–Rao bound over a dwell's pulses"
    if radar.noise:
        snr = case.signal_to_noise(case.middle_m)
        source += f", echo {float(db(snr)):.2g} dB over the noise"
        noise = precision.noise_height_error(radar, snr, case.middle_m)
        if math.isinf(noise):  # without a baseline
            noise, error = precision.noise_phase_error(radar, snr), "rad rms of phase"
    says = f"{radar.receiver.chain} gates, {'thermal' if radar.noise else 'no'} noise"
    yield row("receiver", noise, f"{error} {case.at} by noise", source, says)
    if radar.receiver.chain == "digital":
        yield converter(case)


def _magnetron(case: Case, pairs: bool) -> Row:
    """pairs: whether heights come from pulses that were sent with unlike phases."""
    radar, error = case.scene.radar, transmit_phase_error(case.scene.radar)
    carrier = f"its carrier strays by {1e-3 * radar.frequency_jitter_hz:g} kHz rms"
    if not measures_phase(radar):
        says = f"a random phase at each pulse; {carrier}; heights come from single pulses, and there are no velocities"
        height, source = precision.carrier_height_error(radar), "h δ/f over the pulses of a dwell"
        return row("magnetron", height, f"{HEIGHT} by its carrier", source, says)
    says = f"a random phase at each pulse, taken off to {math.degrees(error):g}° rms; {carrier}"
    lost, source = 1.0 - pulse_coherence(radar), "1 − exp(−σ²)"
    if not pairs or antenna_array(radar).baseline_m == 0.0:
        return row("magnetron", lost, "1 of the coherence between pulses", source, f"{says}; heights do not use it")
    height, source = precision.pair_height_error(radar, error, case.middle_m), "σ √(2/N) of N pulses of either receiver"
    return row("magnetron", height, f"{HEIGHT} {case.at}, of a look as a whole", source, says)


def converter(case: Case) -> Row:
    """The same number, modelled or not; automatic gain takes the near gate's echo for the strongest."""
    radar, receiver = case.scene.radar, case.scene.radar.receiver
    strongest = case.signal_to_noise(float(link.window_m(radar)[0])) * noise_power(radar)
    try:
        noise = quantisation_db(radar, float(full_scale_w(radar, strongest)))
    except ValueError:  # settings of a receiver that is not used need not fit
        noise = math.nan
    says = "ideal complex gates; radar.receiver.chain = 'digital' has the converter"
    if receiver.chain == "digital":
        says = f"{receiver.gain} gain, {1e-6 * receiver.adc_rate_hz:g} MS/s, decimation by {decimation(radar)}"
    error, source = "dB of noise over the thermal noise", f"q²/12 (Bennett 1948), {receiver.adc_bits} bits"
    return row("analogue-to-digital conversion", noise, error, source, says)


def _boat(case: Case) -> Iterator[Row]:
    boat = case.scene.platform
    sensors = "sensors perfect" if boat.sensors == type(boat.sensors)() else "its sensors err"
    says = f"platform.motion = '{boat.motion}', {boat.speed_m_s:g} m/s; {sensors}"
    tilt = 0.0 if boat == PlatformSettings() else case.boat_tilt
    yield row("boat", case.middle_m * tilt, f"{HEIGHT} {case.at}", TILT.format(math.degrees(tilt)), says)

    radar, objects, over = case.scene.radar, case.scene.objects, list[float]()
    near, far = link.window_m(radar)[[0, -1]]
    for each in objects:
        if each.rcs_dbsm is not None:
            distance = float(np.clip(np.linalg.norm(each.position_m), near, far))
            over.append(link.signal_to_clutter_db(radar, each.rcs_dbsm, case.level(distance), distance))
    says = f"{len(objects)} hide the sea behind them, {len(over)} of them echo themselves"
    if over:
        yield row("objects", max(over), "dB over the sea in its cell, at most", "rcs/(σ0 A) of each", says)
    elif objects:
        yield row("objects", float(len(objects)), "objects would not hide the sea", "their number", says)


def _spikes(scattering: ScatteringSettings) -> bool:
    return scattering.nrcs == "two_scale" and scattering.breaking and scattering.sea_spikes


def _said(words: Mapping[str, bool]) -> str:
    return "; ".join(each for each, holds in words.items() if holds)


GROUPS = (_sea, _echoes, _radar, _boat)  # in the order of the account
