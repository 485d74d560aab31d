"""What a run models, how, and the error of leaving it out: rows of the account, and what each costs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..conventions import db, radar_wavenumber
from ..interferometry.interferogram import LASTING
from ..physics.shadowing import shadow_kept
from ..radar import link, precision
from ..radar.array import Array, antenna_array, common_squint_deg
from ..radar.digital import decimation, full_scale_w, quantisation_db
from ..radar.platform import tilt_std
from ..radar.receiver import measures_phase, noise_power, pulse_coherence, transmit_phase_error
from ..radar.scan import scanned_share
from ..radar.waveform import RangeResponse, blind_range_m
from ..scattering import MEAN_MODELS, ShortWaves, clutter_shape_watts_wicks90, mean_level
from ..scattering.bragg import bragg_speed
from ..scattering.breaking import modulation_db, relaxation_rate
from ..scattering.composite import FrontFacets, front_facets
from ..scattering.sea_spikes import sea_spikes
from ..scattering.texture import Texture
from ..scene import Scene
from ..sea import ResolvedSea, ResolvedWaves
from ..settings import PlatformSettings, RadarSettings

Row = dict[str, Any]  # in the keys of metrics.json: what, why, error, value, unit, source
Rows = Sequence[Mapping[str, Any]]

HEIGHT, CYCLES = "m rms of height", "cycles of phase in a dwell"  # units and errors
MEAN_ECHO, OWN_ECHO = "dB of the mean echo", "dB of facets' own echo"
STILL = "√2 σ √(1 − ρ), against the sea half-way through (Longuet-Higgins 1957)"  # sources
BURSTS = "1 is the shape of measured bursts' K-distribution"
PATTERN = "integral of the two-way azimuth pattern"
TWO_SCALE = "two-scale theory over slopes that face the antenna and over winds"
TILT = "range × tilt along the look, {:.2g}° rms"
UNRESOLVED, TILTS = "shadowing by waves that are not resolved", "Smith (1967), their slopes"
BENT = "Smith (1967), less the knife-edge field in a mean shadow"


def row(name: str, value: float, error: str, source: str, says: str) -> Row:
    """error: the value's unit, "1" where there is none, and words that follow; says: how it is modelled, or why not."""
    unit, words = error.split(" ", 1)
    amount = f"{float(f'{value:.2g}'):g}" + ("" if unit == "1" else f" {unit}")
    cost = "nothing" if unit == "m" and value == 0.0 else f"{amount} {words}"
    return {"what": name, "why": says, "error": cost, "value": value, "unit": unit, "source": source}


_TURN = ("sea", "mesh", "trace", "objects", "echoes")  # what a simulated turn waits for
_STAGES = {  # others by their own names
    "sea": ("sea", "mesh"),
    "shadowing": ("trace",),
    UNRESOLVED: ("shade",),
    "receiver": ("receive",),
}
_WITHIN = {  # others: within the echoes
    "scan": "sea",
    "boat": "sea",
    "sea spikes": "scattering",
    "analogue-to-digital conversion": "receive",
}
_ONCE = {"scattering": "calibrate"}


def costed(rows: Rows, timing: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The rows with `cost` in words, and `cost_s` [s] and `cost_share` of a turn where they can be separated.

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


@dataclass(frozen=True)
class Case:
    """A scene, its resolved sea, and what several rows need of both. Errors are stated in the window's middle."""

    scene: Scene
    resolved: ResolvedSea

    @property
    def radar(self) -> RadarSettings:
        return self.scene.radar

    @cached_property
    def array(self) -> Array:
        return antenna_array(self.radar)

    def level(self, range_m: float) -> float:
        """Mean σ0, a ratio."""
        grazing_deg = np.degrees(link.grazing_angle(self.radar, range_m))
        return float(mean_level(self.scene.scattering, grazing_deg, self.radar.frequency_hz))

    def signal_to_noise(self, range_m: float) -> float:
        return link.signal_to_noise(self.radar, self.level(range_m), range_m)

    @cached_property
    def middle_m(self) -> float:
        return link.middle_m(self.radar)

    @property
    def place(self) -> str:
        return f"at {self.middle_m:.0f} m"

    @cached_property
    def grazing(self) -> float:
        """rad, there."""
        return float(link.grazing_angle(self.radar, self.middle_m))

    @cached_property
    def cell_m2(self) -> float:
        """Area of a cell there."""
        return float(link.cell_area(self.radar, self.middle_m))

    @property
    def clutter_shape(self) -> float:
        """Shape that measured seas' echoes have there; NaN beyond the law."""
        return clutter_shape_watts_wicks90(math.degrees(self.grazing), self.cell_m2, self.scene.scattering.polarization)

    @cached_property
    def waves(self) -> ResolvedWaves:
        return ResolvedWaves.of(self.scene.sea, self.resolved.wavenumber_limit)

    @cached_property
    def facing(self) -> FrontFacets:
        return front_facets(self.scene.scattering, self.radar.frequency_hz, self.grazing, self.resolved)

    @cached_property
    def strain_db(self) -> float:
        """Rms hydrodynamic modulation."""
        rate = relaxation_rate(self.radar.frequency_hz, self.scene.scattering.wind_speed_m_s)
        return modulation_db(self.waves.strain_std(rate))

    @cached_property
    def tilting(self) -> tuple[float, float]:
        """Rms height [m] and slope along the look of the waves that tilt the facets, over all looks."""
        short = ShortWaves.of(self.scene.scattering, self.resolved.wavenumber_limit)
        divide = short.divide(radar_wavenumber(self.radar.frequency_hz))
        return short.tilt_height(divide), math.sqrt(0.5 * sum(short.tilt_variances(divide)))

    @cached_property
    def shadow_power(self) -> float:
        """Share of its two-way power that water keeps which these waves hide from light."""
        return shadow_kept(*self.tilting, self.scene.wavelength_m, self.scene.scattering.polarization)

    @cached_property
    def hidden_by_tilts(self) -> float:
        """% of the window that these waves hide from light on top of the resolved ones."""
        radar, slopes = self.radar, self.resolved.look_slope_variance
        both = link.shadowed_share(radar, slopes + self.tilting[1] ** 2)
        return 100.0 * (both - link.shadowed_share(radar, slopes))

    @cached_property
    def boat_tilt(self) -> float:
        """Rms tilt [rad] along the look; of a boat that has no motion, that which the waves would give it."""
        boat = self.scene.platform
        moving = boat.model_copy(update={"motion": "wave_following"}) if boat == PlatformSettings() else boat
        return tilt_std(moving, self.scene.turns * self.scene.turn_duration_s, self.waves)


def _sea(case: Case) -> Iterator[Row]:
    sea, tracing, radar, resolved = case.scene.sea, case.scene.tracing, case.radar, case.resolved
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
                f"; what is hidden keeps {case.shadow_power:.0%} of its echo in {case.scene.scattering.polarization}"
            )
            hidden, source = hidden * (1.0 - case.shadow_power), BENT
        yield row(UNRESOLVED, hidden, error, source, says)


def _echoes(case: Case) -> Iterator[Row]:
    radar, scattering = case.radar, case.scene.scattering
    theory, model = scattering.nrcs == "two_scale", MEAN_MODELS.get(scattering.mean_model or "")
    paper = model.paper if model else ""
    around = "" if model is None or model.knows_wind_direction else " over azimuth"
    says = {
        f"{scattering.nrcs_db:g} dB per horizontal area, shadowing on top": scattering.nrcs == "constant",
        f"the mean of {paper} on every lit facet, shadowing counted once": not theory and model is not None,
        "Bragg waves and mirrors on each facet, tilted by it and by the waves that the mesh does not carry": theory,
        "their height modulated by the strain of the resolved waves": theory and scattering.hydrodynamic_modulation,
        "breakers, most of them where the resolved waves converge": theory and scattering.breaking,
        "each a burst that runs with its wave, grows and fades": scattering.has_sea_spikes,
        f"mean{around} calibrated to {paper}, shadowing counted once": theory and model is not None,
        "theory's own mean": theory and model is None,
    }
    if theory:
        level, error, source = case.facing.modulation_db, OWN_ECHO, TWO_SCALE
    else:
        level, error, source = -float(db(case.level(case.middle_m))), MEAN_ECHO, f"σ0 of {scattering.nrcs} below 1"
    yield row("scattering", level, f"{error} {case.place}", source, f"{scattering.polarization}: {_join_true(says)}")

    if scattering.has_sea_spikes:
        spikes = sea_spikes(scattering.wind_speed_m_s, scattering.inverse_wave_age, radar.frequency_hz)
        own = math.inf if spikes is None else float(spikes.shape(case.cell_m2))
        says = f"a Poisson process of breakers, whose texture on a level sea has the shape {own:.2g} {case.place}"
        yield row("sea spikes", case.clutter_shape, f"{BURSTS} {case.place}", "Watts & Wicks (1990)", says)

    if theory and scattering.breaking and scattering.texture:
        yield patches(case, "lognormal patches that live for seconds and run before the wind")

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
    radar, array, sigma = case.radar, case.array, case.resolved.elevation_std
    paths, first, squint = array.phase_paths, array.first_antenna, common_squint_deg(radar)
    best = array.whole and radar.transmit == "switched" and case.scene.retrieval.paths == "best"
    best = best and pulse_coherence(radar) >= LASTING
    says = {
        f"{radar.transmit} transmitter, {radar.interferogram} interferogram: p = {paths}": True,
        "maps take p = 2 from neighbouring pulses, of which p = 1 tells the cycle": best,
    }
    wrong, read = (sigma, "doubled") if paths == 2 else (0.5 * sigma, "halved")
    yield row("mode", wrong, HEIGHT, f"σ × |p/p′ − 1|: read with p′ = {3 - paths} heights are {read}", _join_true(says))
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
    yield row("antennas", aside, "% of the echo from more than a beam aside", PATTERN, _join_true(says))

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
    yield row("receiver", noise, f"{error} {case.place} by noise", source, says)
    if radar.receiver.chain == "digital":
        yield converter(case)


def _magnetron(case: Case, pairs: bool) -> Row:
    """pairs: whether heights come from pulses that were sent with unlike phases."""
    radar, error = case.radar, transmit_phase_error(case.radar)
    carrier = f"its carrier strays by {1e-3 * radar.frequency_jitter_hz:g} kHz rms"
    if not measures_phase(radar):
        says = f"a random phase at each pulse; {carrier}; heights come from single pulses, and there are no velocities"
        height, source = precision.carrier_height_error(radar), "h δ/f over the pulses of a dwell"
        return row("magnetron", height, f"{HEIGHT} by its carrier", source, says)
    says = f"a random phase at each pulse, taken off to {math.degrees(error):g}° rms; {carrier}"
    lost, source = 1.0 - pulse_coherence(radar), "1 − exp(−σ²)"
    if not pairs or case.array.baseline_m == 0.0:
        return row("magnetron", lost, "1 of the coherence between pulses", source, f"{says}; heights do not use it")
    height, source = precision.pair_height_error(radar, error, case.middle_m), "σ √(2/N) of N pulses of either receiver"
    return row("magnetron", height, f"{HEIGHT} {case.place}, of a look as a whole", source, says)


def patches(case: Case, says: str) -> Row:
    """The same number, modelled or not."""
    texture = Texture.of(case.scene.scattering.wind_speed_m_s)
    spread = 10.0 / math.log(10.0) * math.sqrt(float(texture.variance(case.grazing)))
    error = f"dB rms of breakers' own echo {case.place}"
    return row("patches of breakers", spread, error, "Watts & Wicks (1990)", says)


def converter(case: Case) -> Row:
    """The same number, modelled or not; automatic gain takes the near gate's echo for the strongest."""
    radar, receiver = case.radar, case.radar.receiver
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
    yield row("boat", case.middle_m * tilt, f"{HEIGHT} {case.place}", TILT.format(math.degrees(tilt)), says)

    radar, objects, over = case.radar, case.scene.objects, list[float]()
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


def _join_true(words: Mapping[str, bool]) -> str:
    return "; ".join(each for each, holds in words.items() if holds)


GROUPS = (_sea, _echoes, _radar, _boat)  # in the order of the account
