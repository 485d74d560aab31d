"""What a run modelled, at what cost, and what it left out, at what error: for `metrics.json`, the report and the shell.

Each row holds one number, for one scene and its resolved sea: a closed form of the package that owns its subject, or
what one of the simulation's own models says. A row whose number is not finite does not hold for the scene, and is left
out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..conventions import db
from ..echoes.unheard import beams_heard, share_unheard, unheard_error_m
from ..interferometry.looks import LASTING
from ..physics.propagation import earth_drop_m, edge_blur_m
from ..physics.shadowing import second_bounce_share
from ..radar import link, precision
from ..radar.array import antenna_array, common_squint_deg
from ..radar.digital import decimation, full_scale_w, quantisation_db
from ..radar.platform import tilt_std
from ..radar.receiver import noise_power
from ..radar.scan import BEAMS_BEYOND, scanned_share, sector_width
from ..radar.transmitter import measures_phase, pulse_coherence, stray_within_pulse, transmit_phase_error
from ..radar.waveform import RangeResponse, blind_range_m
from ..scattering import MEAN_MODELS, ShortWaves, clutter_shape_watts_wicks90, mean_level, sea_state_from_wind
from ..scattering.bragg import bragg_speed, radar_wavenumber
from ..scattering.composite import Facing, facing_facets
from ..scattering.mean_models import models_spread_db, wind_contrast_db
from ..scattering.modulation import modulation_db, relaxation_rate
from ..scattering.sea_spikes import sea_spikes
from ..scene import Scene
from ..sea import Resolved, ResolvedWaves
from ..settings import PlatformSettings, ScatteringSettings

Row = dict[str, Any]  # in the keys of metrics.json: what, why, error, value, unit, source
Rows = Sequence[Mapping[str, Any]]
_WELL_SAMPLED = 0.97  # share of a system's variance from which on the patch's wavenumbers hold it
_STEEPEST, _HIGHEST = 0.06, 0.6  # of real seas, about: Hs over the length of the peak, Hs over the depth
_RAYLEIGH = 0.5 * math.pi  # rad of phase by heights, from which on a surface is rough
_MIRROR_PATHS = 16.0  # (1 + |ρ|)⁴, |ρ| = 1: a direct and a reflected path, there and back

_HEIGHT, _CYCLES = "m rms of height", "cycles of phase in a dwell"  # units and errors
_MEAN_ECHO, _OWN_ECHO = "dB of the mean echo", "dB of facets' own echo"
_STILL = "√2 σ √(1 − ρ), against the sea half-way through (Longuet-Higgins 1957)"  # sources
_BURSTS = "1 is the shape of measured bursts' K-distribution"
_PATTERN = "integral of the two-way azimuth pattern"
_TWO_SCALE = "two-scale theory over slopes that face the antenna and over winds"
_TILT = "range × tilt along the look, {:.2g}° rms"
_UNRESOLVED, _TILTS = "shadowing by waves that are not resolved", "Smith (1967), their slopes"
_CRESTS = "of a narrow-banded sea (Longuet-Higgins 1963)"


@dataclass(frozen=True)
class _Case:
    """A scene, its resolved sea, and what several rows need of both. Errors are stated in the window's middle."""

    scene: Scene
    resolved: Resolved

    def level(self, range_m: float) -> float:
        """Mean σ0, a ratio."""
        grazing_deg = np.degrees(link.grazing_angle(self.scene.radar, range_m))
        return float(mean_level(self.scene.scattering, grazing_deg, self.scene.radar.frequency_hz))

    def signal_to_noise(self, range_m: float) -> float:
        return link.signal_to_noise(self.scene.radar, self.level(range_m), range_m)

    @cached_property
    def middle_m(self) -> float:
        return link.middle_m(self.scene.radar)

    @property
    def at(self) -> str:
        return f"at {self.middle_m:.0f} m"

    @cached_property
    def grazing(self) -> float:
        """rad, there."""
        return float(link.grazing_angle(self.scene.radar, self.middle_m))

    @cached_property
    def cell_m2(self) -> float:
        """Area of a cell there."""
        return float(link.cell_area(self.scene.radar, self.middle_m))

    @property
    def clutter_shape(self) -> float:
        """Shape that measured seas' echoes have there; NaN beyond the law."""
        return clutter_shape_watts_wicks90(math.degrees(self.grazing), self.cell_m2, self.scene.scattering.polarization)

    @cached_property
    def waves(self) -> ResolvedWaves:
        return ResolvedWaves.of(self.scene.sea, self.resolved.wavenumber_limit)

    @cached_property
    def facing(self) -> Facing:
        return facing_facets(self.scene.scattering, self.scene.radar.frequency_hz, self.grazing, self.resolved)

    @cached_property
    def strain_db(self) -> float:
        """Rms hydrodynamic modulation."""
        rate = relaxation_rate(self.scene.radar.frequency_hz, self.scene.scattering.wind_speed_m_s)
        return modulation_db(self.waves.strain_std(rate))

    @property
    def hides_unresolved(self) -> bool:
        return self.scene.tracing.unresolved_shadowing != "none"

    @cached_property
    def tilting(self) -> tuple[float, float]:
        """Rms height [m] and slope along the look of the waves that tilt the facets, over all looks."""
        short = ShortWaves.of(self.scene.scattering, self.resolved.wavenumber_limit)
        divide = short.divide(radar_wavenumber(self.scene.radar.frequency_hz))
        height = short.variance - short.roughness_variance(divide)
        return math.sqrt(max(height, 0.0)), math.sqrt(0.5 * sum(short.tilt_variances(divide)))

    @cached_property
    def hidden_by_tilts(self) -> float:
        """% of the window that these waves hide on top of the resolved ones."""
        radar, slopes = self.scene.radar, self.resolved.look_slope_variance
        both = link.shadowed_share(radar, slopes + self.tilting[1] ** 2)
        return 100.0 * (both - link.shadowed_share(radar, slopes))

    @cached_property
    def boat_tilt(self) -> float:
        """Rms tilt [rad] along the look; of a boat that has no motion, that which the waves would give it."""
        boat = self.scene.platform
        moving = boat.model_copy(update={"motion": "wave_following"}) if boat == PlatformSettings() else boat
        return tilt_std(moving, self.scene.turns * self.scene.turn_duration_s, self.waves)


def modelled(scene: Scene, resolved: Resolved) -> list[Row]:
    """Rows of what was modelled, how, and the error of leaving it out: what, why, error, value, unit, source."""
    return _finite(_Case(scene, resolved), _sea, _echoes, _radar, _boat)


def left_out(scene: Scene, resolved: Resolved) -> list[Row]:
    """Rows of what was not, why or by which key it would be, and the error that this costs; keys as of `modelled`."""
    return _finite(_Case(scene, resolved), _no_geometry, _no_boat, _no_scattering, _no_mean, _no_sea)


def _finite(case: _Case, *groups: Callable[[_Case], Iterator[Row]]) -> list[Row]:
    return [row for group in groups for row in group(case) if math.isfinite(row["value"])]


def _row(name: str, value: float, error: str, source: str, says: str) -> Row:
    """error: the value's unit, "1" where there is none, and words that follow; says: how it is modelled, or why not."""
    unit, words = error.split(" ", 1)
    amount = f"{float(f'{value:.2g}'):g}" + ("" if unit == "1" else f" {unit}")
    told = "nothing" if unit == "m" and value == 0.0 else f"{amount} {words}"
    return {"what": name, "why": says, "error": told, "value": value, "unit": unit, "source": source}


def _spikes(scattering: ScatteringSettings) -> bool:
    return scattering.nrcs == "two_scale" and scattering.breaking and scattering.sea_spikes


def _said(words: Mapping[str, bool]) -> str:
    return "; ".join(each for each, holds in words.items() if holds)


# ---------------------------------------------------------------------------------------------- what is modelled


def _sea(case: _Case) -> Iterator[Row]:
    sea, tracing, radar, resolved = case.scene.sea, case.scene.tracing, case.scene.radar, case.resolved
    shares = f"{resolved.variance_share:.2%} of the variance, {resolved.mean_square_slope_share:.0%} of the slopes'"
    says = f"{sea.model}, evolving; waves longer than {2.0 * resolved.resolution_m:.3g} m resolved: {shares}"
    yield _row("sea", resolved.elevation_std, _HEIGHT, "σ of the resolved spectrum", says)
    still = case.waves.still_sea_error(scanned_share(radar) * case.scene.turn_duration_s)
    says = "azimuth is time: each column of the sea is meshed when the beam passes it"
    if radar.scan == "staring":
        still, says = 0.0, f"staring for {1e3 * radar.stare_s:g} ms a map, of the sea as it is half-way"
    yield _row("scan", still, _HEIGHT, _STILL, says)

    says = {
        "facets": "a shadow ray to each facet that faces the antenna, for each antenna, traced by Sionna RT/Mitsuba",
        "horizon": "running maximum of the elevation angle, float64",
        "paths": "a line-of-sight path to each facet, for each antenna, by Sionna RT's PathSolver",
    }[tracing.tracer]
    says += "; near a crest's shadow the field of two knife edges" if tracing.diffraction == "knife_edge" else ""
    hidden = 100.0 * link.shadowed_share(radar, case.resolved.look_slope_variance)
    error, source = "% of the window would answer from the shade", "Smith (1967), slopes of the resolved waves"
    yield _row("shadowing", hidden, error, source, says)
    if case.hides_unresolved:
        says = "of each lit facet the share that its own grazing angle leaves in sight, for both antennas alike"
        yield _row(_UNRESOLVED, case.hidden_by_tilts, error, _TILTS, says)


def _echoes(case: _Case) -> Iterator[Row]:
    radar, scattering = case.scene.radar, case.scene.scattering
    theory, model = scattering.nrcs == "two_scale", MEAN_MODELS.get(scattering.mean_model or "")
    paper = model.paper if model else ""
    says = {
        f"{scattering.nrcs_db:g} dB per horizontal area, shadowing on top": scattering.nrcs == "constant",
        f"the mean of {paper} on every lit facet, shadowing counted once": not theory and model is not None,
        "Bragg waves and mirrors on each facet, tilted by it and by the waves that the mesh does not carry": theory,
        "their height modulated by the strain of the resolved waves": theory and scattering.hydrodynamic_modulation,
        "breakers, most of them where the resolved waves converge": theory and scattering.breaking,
        "each a burst that runs with its wave, grows and fades": _spikes(scattering),
        f"mean calibrated to {paper}, shadowing counted once": theory and model is not None,
        "theory's own mean": theory and model is None,
    }
    if theory:
        level, error, source = case.facing.modulation_db, _OWN_ECHO, _TWO_SCALE
    else:
        level, error, source = -float(db(case.level(case.middle_m))), _MEAN_ECHO, f"σ0 of {scattering.nrcs} below 1"
    yield _row("scattering", level, f"{error} {case.at}", source, f"{scattering.polarization}: {_said(says)}")

    if _spikes(scattering):
        spikes = sea_spikes(scattering.wind_speed_m_s, scattering.inverse_wave_age, radar.frequency_hz)
        own = math.inf if spikes is None else float(spikes.shape(case.cell_m2))
        says = f"a Poisson process of breakers, whose texture on a level sea has the shape {own:.2g} {case.at}"
        yield _row("sea spikes", case.clutter_shape, f"{_BURSTS} {case.at}", "Watts & Wicks (1990)", says)

    time = scattering.decorrelation_time_s
    looks, says = precision.looks(radar, time), f"complex Gaussian per facet, decorrelation time {1e3 * time:g} ms"
    error, source = "dB of scatter of a gate's mean power over a dwell", f"1/√looks, {looks:.2g} looks a dwell"
    yield _row("speckle", precision.speckle_db(looks), error, source, says)

    water, bragg, says = case.waves.orbital_speed(), 0.0, "each facet's phase follows its water particle"
    source = f"2vT/λ, v = {water:.2g} m/s rms of orbits"
    if scattering.doppler != "orbital":
        bragg = bragg_speed(radar.frequency_hz)
        source += f" and {bragg:.2g} m/s of Bragg waves"
        says += f", with Bragg waves{' and breakers' if theory and scattering.breaking else ''} at their own speeds"
    yield _row("motion", precision.doppler_cycles(radar, math.hypot(water, bragg)), _CYCLES, source, says)


def _radar(case: _Case) -> Iterator[Row]:
    radar, array, sigma = case.scene.radar, antenna_array(case.scene.radar), case.resolved.elevation_std
    paths, first, squint = array.phase_paths, array.first_antenna, common_squint_deg(radar)
    best = array.whole and radar.transmit == "switched" and case.scene.retrieval.paths == "best"
    best = best and pulse_coherence(radar) >= LASTING
    says = {
        f"{radar.transmit} transmitter, {radar.interferogram} interferogram: p = {paths}": True,
        "maps take p = 2 from neighbouring pulses, of which p = 1 tells the cycle": best,
    }
    wrong, read = (sigma, "doubled") if paths == 2 else (0.5 * sigma, "halved")
    yield _row("mode", wrong, _HEIGHT, f"σ × |p/p′ − 1|: read with p′ = {3 - paths} heights are {read}", _said(says))
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
    yield _row("antennas", aside, "% of the echo from more than a beam aside", _PATTERN, _said(says))

    cell, says = RangeResponse.of(radar).resolution_m, f"{radar.waveform} of {1e9 * radar.pulse_width_s:g} ns"
    matched = f"; its echoes from nearer than {blind_range_m(radar):.3g} m are lost in part"
    says += matched if radar.waveform == "chirp" else " through a Gaussian filter"
    blur = math.sqrt(case.resolved.mean_square_slope / 24.0) * cell
    yield _row("waveform", blur, _HEIGHT, f"slope × {cell:.3g} m/√12, all within a gate", says)

    noise, error, source = 0.0, _HEIGHT, "Cramér–Rao bound over a dwell's pulses"
    if radar.noise:
        snr = case.signal_to_noise(case.middle_m)
        source += f", echo {float(db(snr)):.2g} dB over the noise"
        noise = precision.noise_height_error(radar, snr, case.middle_m)
        if math.isinf(noise):  # without a baseline
            noise, error = precision.noise_phase_error(radar, snr), "rad rms of phase"
    says = f"{radar.receiver.chain} gates, {'thermal' if radar.noise else 'no'} noise"
    yield _row("receiver", noise, f"{error} {case.at} by noise", source, says)
    if radar.receiver.chain == "digital":
        yield _converter(case)


def _magnetron(case: _Case, pairs: bool) -> Row:
    """pairs: whether heights come from pulses that were sent with unlike phases."""
    radar, error = case.scene.radar, transmit_phase_error(case.scene.radar)
    carrier = f"its carrier strays by {1e-3 * radar.frequency_jitter_hz:g} kHz rms"
    if not measures_phase(radar):
        says = f"a random phase at each pulse; {carrier}; heights come from single pulses, and there are no velocities"
        height, source = precision.carrier_height_error(radar), "h δ/f over the pulses of a dwell"
        return _row("magnetron", height, f"{_HEIGHT} by its carrier", source, says)
    says = f"a random phase at each pulse, taken off to {math.degrees(error):g}° rms; {carrier}"
    lost, source = 1.0 - pulse_coherence(radar), "1 − exp(−σ²)"
    if not pairs or antenna_array(radar).baseline_m == 0.0:
        return _row("magnetron", lost, "1 of the coherence between pulses", source, f"{says}; heights do not use it")
    height, source = precision.pair_height_error(radar, error, case.middle_m), "σ √(2/N) of N pulses of either receiver"
    return _row("magnetron", height, f"{_HEIGHT} {case.at}, of a look as a whole", source, says)


def _converter(case: _Case) -> Row:
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
    return _row("analogue-to-digital conversion", noise, error, source, says)


def _boat(case: _Case) -> Iterator[Row]:
    boat = case.scene.platform
    sensors = "sensors perfect" if boat.sensors == type(boat.sensors)() else "its sensors err"
    says = f"platform.motion = '{boat.motion}', {boat.speed_m_s:g} m/s; {sensors}"
    tilt = 0.0 if boat == PlatformSettings() else case.boat_tilt
    yield _row("boat", case.middle_m * tilt, f"{_HEIGHT} {case.at}", _TILT.format(math.degrees(tilt)), says)

    radar, objects, over = case.scene.radar, case.scene.objects, list[float]()
    near, far = link.window_m(radar)[[0, -1]]
    for each in objects:
        if each.rcs_dbsm is not None:
            distance = float(np.clip(np.linalg.norm(each.position_m), near, far))
            over.append(link.signal_to_clutter_db(radar, each.rcs_dbsm, case.level(distance), distance))
    says = f"{len(objects)} hide the sea behind them, {len(over)} of them echo themselves"
    if over:
        yield _row("objects", max(over), "dB over the sea in its cell, at most", "rcs/(σ0 A) of each", says)
    elif objects:
        yield _row("objects", float(len(objects)), "objects would not hide the sea", "their number", says)


# ---------------------------------------------------------------------------------------------- what is left out


def _no_geometry(case: _Case) -> Iterator[Row]:
    radar, detail, array = case.scene.radar, case.scene.detail, antenna_array(case.scene.radar)
    far, width, bounced = radar.range_m[1], sector_width(radar), second_bounce_share(case.resolved.mean_square_slope)
    error, source = "% of what scatters evenly meets the sea again", "view factors of resolved waves"
    says = "the second bounce is not traced, and that of mirrors not estimated"
    yield _row("multiple scattering", 100.0 * bounced, error, source, says)
    name, source = "slopes of resolved waves that the mesh is too coarse for", "the mesh sizing model (`mesh.sizing`)"
    cost = f"{detail.power_error_db:.2g} dB of power, {detail.visible_error:.1%} of what is visible"
    says = f"rungs {detail.facet_m:g} m apart, {detail.columns_per_beam} columns a beam; lower tracing.height_error_m"
    yield _row(name, detail.height_error_m, f"m rms of the maps' heights, {cost}", source, says)
    yield _unheard(case)
    error, source = f"m of height at {far:.0f} m", "d²/2R, 4/3 of the Earth's radius"
    yield _row("Earth curvature", earth_drop_m(far), error, source, "the Earth is flat")
    if radar.scan == "turning" and width < 360.0:
        beyond, error = 100.0 * array.first_antenna.share_beyond(BEAMS_BEYOND), "% of the echo, from further aside"
        unseen = f"{100.0 - width / 3.6:.2g} % of the circle is neither meshed nor traced"
        says = f"radar.sector_deg is {width:g}° wide: {unseen}, beyond {BEAMS_BEYOND:g} beams beside it"
        yield _row("the rest of the circle", beyond, error, _PATTERN, says)
    if radar.receiver.chain == "baseband":
        yield _converter(case)
    if radar.transmitter == "magnetron" and radar.frequency_jitter_hz:
        lost, error = stray_within_pulse(radar) ** 2, "1 of the coherence between pulses"
        says = "phases that the carrier's jitter turns across a pulse: a gate's facets take that of its middle"
        yield _row("a magnetron's jitter within a pulse", lost, error, "(2π δ s)², s of a gate's delays", says)
    if radar.scan == "staring":
        kept = math.exp(-((radar.stare_s / case.scene.scattering.decorrelation_time_s) ** 2))
        name, source = "speckle from one map to the next", "exp(−(τ/τc)²) of two pulses one map apart"
        yield _row(name, kept, "1 of correlation", source, "each map of a staring antenna has speckle of its own")
        still, says = case.waves.still_sea_error(radar.stare_s), f"for the {1e3 * radar.stare_s:g} ms of a map"
        yield _row("the sea's motion within a map", still, _HEIGHT, _STILL, f"it stands still {says}")


def _unheard(case: _Case) -> Row:
    """What comes from further aside, or in range, than facets are summed."""
    radar, sigma = case.scene.radar, case.resolved.elevation_std
    share = share_unheard(sigma, case.scene.tracing.height_error_m)
    aside = "" if radar.scan == "staring" else f" within {beams_heard(radar, share):.3g} beams to either side"
    says = f"facets are summed{aside} up to {float(db(share)):.2g} dB of the power; lower tracing.height_error_m"
    error, source = "m rms of height, of a single sample", "√p σ, p of the power (`echoes.unheard`)"
    name = "the beam's outer sides and the pulse's flanks"
    return _row(name, unheard_error_m(radar, sigma, share), error, source, says)


def _no_boat(case: _Case) -> Iterator[Row]:
    scene, boat, tilt = case.scene, case.scene.platform, case.boat_tilt
    if boat == PlatformSettings():
        error, source = f"{_HEIGHT} {case.at}, were it unknown", _TILT.format(math.degrees(tilt))
        says = "it lies still; platform.motion = 'wave_following' lets it ride"
        yield _row("the boat's own motion", case.middle_m * tilt, error, source, says)
    elif boat.motion == "wave_following":
        error, source = "° rms of tilt without them; with them not known", "least-squares plane of the waves"
        yield _row("the boat's dynamics", math.degrees(tilt), error, source, "it follows the waves without resonance")
    if boat.motion != "fixed" or boat.list_deg or boat.trim_deg:
        name, source = "the waves' effect on where a leaning beam meets the sea", "σ × tan of the lean"
        off, says = case.resolved.elevation_std * math.tan(tilt), "the fan is laid on the mean sea"
        yield _row(name, off, "m rms of position", source, says)
    sailed = boat.speed_m_s * scene.turns * scene.turn_duration_s
    if sailed > 0.5 * scene.radar.range_m[1]:
        says = "they stay centred on the origin"
        yield _row("ground maps around the boat", sailed, "m of position at the end", "speed × time", says)

    objects, width = scene.objects, scene.radar.antenna.width_m
    nearest = min((float(np.linalg.norm(each.position_m)) for each in objects), default=0.0)
    if nearest > 0.0:
        behind, error = width * max(0.0, case.middle_m / nearest - 1.0), f"m of half shadow {case.at}"
        source = f"aperture of {width:g} m past an object at {nearest:.2g} m"
        yield _row("the antennas' width", behind, error, source, "an object hides what lies behind it from a point")
    if any(each.rcs_dbsm is not None for each in objects):
        name, error = "echoes between objects and the sea", "dB of an object's echo, at most"
        says = "an object echoes by its own cross-section alone"
        yield _row(name, float(db(_MIRROR_PATHS)), error, "bound of a mirror (Kerr 1951)", says)

    to_shade = 0.5 * case.resolved.peak_length  # from a crest: at most a wave, half of one in the mean
    blur = edge_blur_m(scene.wavelength_m, case.middle_m, to_shade)
    source = f"knife edge (ITU-R P.526), {to_shade:.2g} m before the shade: half the peak's length"
    name, error = "diffraction at shadow edges", f"m of height {case.at}, over which an edge fades"
    says = "geometric shadows; tracing.diffraction = 'knife_edge'"
    if scene.tracing.diffraction != "none":
        name, error = "what diffraction does to heights", f"m of height {case.at} beside an edge, at most"
        says = "a shadow answers with its crest's height, and fringes pull heights down; the stated error knows neither"
    yield _row(name, blur, error, source, says)
    yield _unresolved_shadows(case)


def _unresolved_shadows(case: _Case) -> Row:
    """What they hide, or that a shadow so short is not sharp."""
    height, slope = case.tilting
    if not case.hides_unresolved:
        name, error = "shadows of waves that are not resolved", "% of the window would be hidden"
        phase = 2.0 * radar_wavenumber(case.scene.radar.frequency_hz) * height * slope
        rough = "rough to it too" if phase > _RAYLEIGH else f"smooth to it, {phase:.2g} rad of Rayleigh's π/2"
        says = f"light's measure; met at their own slope they are {rough}; tracing.unresolved_shadowing = 'smith'"
        return _row(name, case.hidden_by_tilts, error, _TILTS, says)
    length = height / slope if slope > 0.0 else 0.0
    name, error = "diffraction at shadows of waves that are not resolved", f"m of height, of waves {height:.2g} m high"
    source = f"knife edge (ITU-R P.526), {length:.2g} m before the shade: rms height over rms slope"
    says = "they hide what they would hide from light; the mean echo is that of the calibration all the same"
    return _row(name, edge_blur_m(case.scene.wavelength_m, case.middle_m, length), error, source, says)


def _no_scattering(case: _Case) -> Iterator[Row]:
    scattering, radar, own_echo = case.scene.scattering, case.scene.radar, f"{_OWN_ECHO} {case.at}"
    if scattering.doppler == "orbital":
        speed, says = bragg_speed(radar.frequency_hz), "facets move with the water only; scattering.doppler = 'full'"
        cycles, source = precision.doppler_cycles(radar, speed), f"2vT/λ, v = {speed:.2g} m/s of Bragg waves"
        yield _row("the scatterers' own velocity", cycles, _CYCLES, source, says)
    if scattering.nrcs != "two_scale":
        spread, source = math.hypot(case.facing.modulation_db, case.strain_db), f"{_TWO_SCALE}; 4.5 × rms strain"
        says = "what is seen has the mean; scattering.nrcs = 'two_scale' has them, and alone uses their keys"
        yield _row("tilt, strain and breakers", spread, own_echo, source, says)
        return
    if scattering.breaking and not scattering.sea_spikes:
        says = "breakers are a share of each facet; scattering.sea_spikes = true makes them bursts that grow and fade"
        yield _row("a breaker's life", case.clutter_shape, f"{_BURSTS} {case.at}", "Watts & Wicks (1990)", says)
    elif not scattering.breaking:
        says = "scattering.breaking = false: HH owes its mean to the calibration"
        yield _row("breakers", case.facing.breaking_db, f"dB of theory's mean echo {case.at}", _TWO_SCALE, says)
    if not scattering.hydrodynamic_modulation:
        source = "4.5 × rms strain (Alpers & Hasselmann 1978)"
        says = "scattering.hydrodynamic_modulation = false: tilt alone modulates"
        yield _row("hydrodynamic modulation", case.strain_db, own_echo, source, says)


def _no_mean(case: _Case) -> Iterator[Row]:
    scattering, radar = case.scene.scattering, case.scene.radar
    if scattering.mean_model is None:
        return
    model, middle = MEAN_MODELS[scattering.mean_model], (scattering, math.degrees(case.grazing), radar.frequency_hz)
    error, (low, high) = f"{_MEAN_ECHO} {case.at}", model.grazing_deg
    if scattering.extrapolate:
        here = f"sea state {float(sea_state_from_wind(scattering.wind_speed_m_s)):.2g} at {1e-9 * middle[2]:g} GHz"
        name, source = "the clutter model's own range", "spread of the mean models, extrapolated alike"
        says = f"scattering.extrapolate = true: {model.paper} holds for {model.range_words}; this scene is {here}"
        yield _row(name, models_spread_db(*middle), error, source, says)
    if not model.knows_wind_direction:
        name, error = "wind-direction contrast of the mean echo", f"{error}, up-wind over down-wind"
        says = f"{model.paper} is an average over directions; git, tsc and hybrid know them"
        yield _row(name, wind_contrast_db(*middle), error, "mean of models", says)
    outside, source = 100.0 * link.share_outside(radar, low, high), f"grazing angles of {model.paper}"
    name, says = f"the mean outside {low:g}–{high:g}° grazing", "facets beyond take the value at the edge of its range"
    yield _row(name, outside, "% of the window", source, says)


def _no_sea(case: _Case) -> Iterator[Row]:
    sea, resolved, facet = case.scene.sea, case.resolved, case.scene.detail.facet_m
    height, carried = 4.0 * resolved.elevation_std, resolved.carried_share
    if sea.model == "linear":
        source, says = f"kσ² {_CRESTS}", "waves are linear; sea.model = 'choppy' sharpens them"
        yield _row("sharper crests", resolved.second_order_std, _HEIGHT, source, says)
    elif sea.model == "choppy":
        source, says = f"3kσ {_CRESTS}", "0 at the first Lagrangian order"
        yield _row("skewness of the elevation", resolved.skewness_stokes, "1 of skewness", source, says)
    if facet > resolved.resolution_m:
        name = f"slopes of resolved waves shorter than {2.0 * facet:g} m along the look"
        says = "neither the mesh nor the scattering has all of them; lower tracing.facet_m or coarsen sea.resolution_m"
        yield _row(name, case.waves.slopes_lost(facet), "1 rms of slope", "the sea's spectrum", says)
    if carried < _WELL_SAMPLED:
        name, elsewhere = "the longest waves' place in the spectrum", 0.25 * height * math.sqrt(1.0 - carried)
        says = f"the periodic patch samples {carried:.0%} of a system's variance; raise sea.extent_m"
        yield _row(name, elsewhere, f"{_HEIGHT} at other wavelengths", "σ √(1 − share)", says)
    for name, of, length, most in (
        ("breaking, which this sea would do", "the peak's length", resolved.peak_length, _STEEPEST),
        ("breaking on the bed, which this sea would do", "the depth", sea.depth_m, _HIGHEST),
    ):
        if height > most * length:
            error, source = "m of significant height too much", "height over that limit"
            says = f"significant height is {height / length:.2g} of {of}; real seas stay below {most:g}"
            yield _row(name, height - most * length, error, source, says)


# ----------------------------------------------------------------------------------------- costs, and the lines

_TURN = ("sea", "mesh", "trace", "objects", "echoes")  # what a simulated turn waits for
_STAGES = {  # others by their own names
    "sea": ("sea", "mesh"),
    "shadowing": ("trace",),
    _UNRESOLVED: ("shade",),
    "receiver": ("receive",),
}
_WITHIN = {"scan": "sea", "boat": "sea", "analogue-to-digital conversion": "receive"}  # others: within the echoes
_ONCE = {"scattering": "calibrate"}


def costed(rows: Rows, timing: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The rows with `cost` in words, and `cost_s` [s] and `cost_share` of a turn where they can be told apart.

    timing: {"first": {stage: s}, "warm": {stage: s} or None}, of which the warm turns count if there are any.
    """
    first, warm = timing["first"], timing["warm"]
    turn = warm or first
    whole = sum(turn.get(stage, 0.0) for stage in _TURN)
    return [{**row, **_cost(row["what"], turn, whole, first, "" if warm else ", first turn")} for row in rows]


def _cost(name: str, turn: Mapping[str, float], whole: float, first: Mapping[str, float], which: str) -> dict[str, Any]:
    stages = [stage for stage in _STAGES.get(name, (name,)) if stage in turn]
    if not stages:
        within = _WITHIN.get(name, "echoes")
        words = f"within {within}, {turn[within]:.2g} s{which}" if within in turn else "not timed"
        return {"cost": words, "cost_s": None, "cost_share": None}
    seconds = sum(turn[stage] for stage in stages)
    share = seconds / whole if whole > 0.0 else 0.0
    once = first.get(_ONCE.get(name, ""), 0.0)
    words = f"{seconds:.2g} s, {share:.0%} of a turn{which}" + (f"; {once:.2g} s once a run" if once > 0.005 else "")
    return {"cost": words, "cost_s": seconds, "cost_share": share}


def account_lines(modelled: Rows, left_out: Rows, most: int = 20) -> list[str]:
    """What is modelled with its cost, what is left out with its error; beyond `most` lines the last one only names."""
    lines = [
        f"modelled: {row['what']} ({row.get('cost', 'not timed')}; without it {row.get('error') or 'not known'})"
        for row in modelled
    ]
    lines += [f"left out: {row['what']} ({row.get('error') or 'not known'})" for row in left_out]
    if len(lines) <= most:
        return lines
    others = "; ".join(row["what"] for row in [*modelled, *left_out][most - 1 :])
    return [*lines[: most - 1], f"left out: {others} (errors in the report)"]
