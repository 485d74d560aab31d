"""The rows of `limits`: of each part of the simulation its number for one scene and its resolved sea, and its words.

`_ROWS` has their units, errors and sources; the functions below work out the numbers, by a closed form of
`limit_formulas` or by one of the simulation's own models. A row whose number cannot be worked out is left out.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..conventions import db
from ..radar import link
from ..radar.array import antenna_array, common_squint_deg
from ..radar.digital import decimation
from ..radar.receiver import noise_power
from ..radar.scan import BEAMS_BEYOND, scanned_share, sector_width
from ..radar.waveform import RangeResponse, blind_range_m
from ..scattering import MEAN_MODELS, sea_state_from_wind
from ..scattering.modulation import relaxation_rate
from ..scene import Scene
from ..sea import Resolved
from ..settings import PlatformSettings
from . import limit_formulas as formulas

Row = dict[str, Any]  # in the keys of metrics.json: what, why, error, value, unit, source
_WELL_SAMPLED = 0.97  # share of a system's variance from which on the patch's wavenumbers hold it
_STEEPEST, _HIGHEST = 0.06, 0.6  # of real seas, about: Hs over the length of the peak, Hs over the depth
_MIRROR_PATHS = 16.0  # (1 + |ρ|)⁴, |ρ| = 1: a direct and a reflected path, there and back
_HEIGHT, _MEAN_ECHO, _OWN_ECHO = "{} rms of height", "{} of the mean echo {at}", "{} of facets' own echo {at}"
_STILL = "√2 σ √(1 − ρ), against the sea half-way through (Longuet-Higgins 1957)"
_PATTERN = "integral of the two-way azimuth pattern"
_BOUND = "Cramér–Rao bound over a dwell's pulses{snr}"
_TILT = "range × tilt along the look, {tilt:.2g}° rms"
_TWO_SCALE = "two-scale theory over slopes that face the antenna and over winds"
_TOO_HIGH = "{} of significant height too much"
_CRESTS = "of a narrow-banded sea (Longuet-Higgins 1963)"
_MESH = "{} rms of the maps' heights, {power:.2g} dB of power, {visible:.1%} of what is visible"

# Of each row its unit ("1" where there is none), the error of leaving it out, and where that number comes from. What
# follows a colon in a name is not part of it, but says which of two numbers the row has.
_ROWS = {
    # modelled
    "sea": ("m", _HEIGHT, "σ of the resolved spectrum"),
    "scan": ("m", _HEIGHT, _STILL),
    "shadowing": ("%", "{} of the window would answer from the shade", "Smith (1967), slopes of the resolved waves"),
    "scattering": ("dB", "{} of {of} {at}", "{by}"),
    "speckle": ("dB", "{} of scatter of a gate's mean power over a dwell", "1/√looks, {looks:.2g} looks a dwell"),
    "motion": ("cycles", "{} of phase in a dwell", "2vT/λ, v = {water:.2g} m/s rms of orbits{own}"),
    "mode": ("m", _HEIGHT, "σ × |p/p′ − 1|: read with p′ = {other} heights are {read}"),
    "antennas": ("%", "{} of the echo from more than a beam aside", _PATTERN),
    "waveform": ("m", _HEIGHT, "slope × {cell:.3g} m/√12, all within a gate"),
    "receiver": ("m", _HEIGHT + " {at} by noise", _BOUND),
    "receiver: without a baseline": ("rad", "{} rms of phase {at} by noise", _BOUND),
    "boat": ("m", _HEIGHT + " {at}", _TILT),
    "objects": ("dB", "{} over the sea in its cell, at most", "rcs/(σ0 A) of each"),
    "objects: without echoes": ("objects", "the sea behind {} would answer", "their number"),
    # left out, or modelled
    "analogue-to-digital conversion": ("dB", "noise {} over the thermal noise", "q²/12 (Bennett 1948), {bits} bits"),
    # left out
    "multiple scattering": ("%", "{} of what scatters evenly meets the sea again", "view factors of resolved waves"),
    "slopes of resolved waves that the mesh is too coarse for": ("m", _MESH, "the mesh sizing model (`mesh.sizing`)"),
    "Earth curvature": ("m", "{} of height at {far:.0f} m", "d²/2R, 4/3 of the Earth's radius"),
    "the rest of the circle": ("%", "{} of the echo, from further aside", _PATTERN),
    "speckle from one map to the next": ("1", "{} of correlation", "exp(−(τ/τc)²) of two pulses one map apart"),
    "the sea's motion within a map": ("m", _HEIGHT, _STILL),
    "the boat's own motion": ("m", _HEIGHT + " {at}, were it unknown", _TILT),
    "the boat's dynamics": ("°", "not known; its tilt without them is {} rms", "least-squares plane of the waves"),
    "the waves' effect on where a leaning beam meets the sea": ("m", "{} rms of position", "σ × tan of the lean"),
    "ground maps around the boat": ("m", "{} of position at the end", "speed × time"),
    "the antennas' width": ("m", "{} of half shadow {at}", "aperture of {width:g} m past an object at {nearest:.2g} m"),
    "echoes between objects and the sea": ("dB", "up to {} of an object's echo", "bound of a mirror (Kerr 1951)"),
    "diffraction at shadow edges": ("m", "{} of height {at}, over which an edge fades", "{edge}"),
    "what diffraction does to heights": ("m", "up to {} of height {at}, beside an edge", "{edge}"),
    "the scatterers' own velocity": ("cycles", "{} of phase in a dwell", "2vT/λ, v = {speed:.2g} m/s of Bragg waves"),
    "tilt, strain and breakers": ("dB", _OWN_ECHO, _TWO_SCALE + "; 4.5 × rms strain"),
    "shadows of waves that are not resolved": ("%", "{} of the window would be hidden", "Smith (1967), their slopes"),
    "a breaker's life": ("1", "bursts: K-distribution of shape {} in measured echoes {at}", "Watts & Wicks (1990)"),
    "breakers": ("dB", "{} of theory's mean echo {at}", _TWO_SCALE),
    "hydrodynamic modulation": ("dB", _OWN_ECHO, "4.5 × rms strain (Alpers & Hasselmann 1978)"),
    "the clutter model's own range": ("dB", _MEAN_ECHO, "spread of the mean models, extrapolated alike"),
    "wind-direction contrast of the mean echo": ("dB", _MEAN_ECHO + ", up-wind over down-wind", "mean of models"),
    "the mean outside {low:g}–{high:g}° grazing": ("%", "{} of the window", "grazing angles of {paper}"),
    "sharper crests": ("m", _HEIGHT, f"kσ² {_CRESTS}"),
    "skewness of the elevation": ("1", "{} of skewness", f"3kσ {_CRESTS}"),
    "slopes of resolved waves shorter than {step:g} m along the look": ("1", "{} rms of slope", "the sea's spectrum"),
    "the longest waves' place in the spectrum": ("m", _HEIGHT + " at other wavelengths", "σ √(1 − share)"),
    "breaking, which this sea would do": ("m", _TOO_HIGH, "height over that limit"),
    "breaking on the bed, which this sea would do": ("m", _TOO_HIGH, "height over that limit"),
}


@dataclass(frozen=True)
class Case:
    """A scene, its resolved sea, and what several rows need of both, each worked out once."""

    scene: Scene
    resolved: Resolved

    @cached_property
    def waves(self) -> formulas.ResolvedWaves:
        return formulas.resolved_waves(self.scene.sea, self.resolved.wavenumber_limit)

    @cached_property
    def facing(self) -> formulas.Facing:
        return formulas.facing(self.scene, self.resolved)

    @cached_property
    def middle_m(self) -> float:
        """Slant range [m] at which errors are stated."""
        return formulas.middle_m(self.scene.radar)

    @cached_property
    def boat_tilt(self) -> float:
        """Rms tilt [rad] along the look; of a boat that has no motion, that which the waves would give it."""
        platform = self.scene.platform
        if platform.motion == "wave_following" or platform == PlatformSettings():
            return formulas.boat_tilt(self.waves, platform.length_m, platform.beam_m)
        return formulas.boat_tilt_at_rest(self.scene)

    @cached_property
    def strain_db(self) -> float:
        """Rms hydrodynamic modulation."""
        rate = relaxation_rate(self.scene.radar.frequency_hz, self.scene.scattering.wind_speed_m_s)
        return formulas.hydrodynamic_db(formulas.strain_std(self.waves, rate))

    def signal_to_noise(self, range_m: float) -> float:
        return formulas.signal_to_noise(self.scene.radar, formulas.mean_level(self.scene, range_m), range_m)

    def row(self, name: str, value: float, says: str, **words: object) -> Iterator[Row]:
        """The row of that name in `_ROWS`, if its value is finite; says: how it is modelled, or why it is not."""
        if not math.isfinite(value):
            return
        unit, error, source = _ROWS[name]
        words = {"at": f"at {self.middle_m:.0f} m", **words}
        amount = f"{float(f'{value:.2g}'):g}" + ("" if unit == "1" else f" {unit}")
        error = "nothing" if unit == "m" and value == 0.0 else error.format(amount, **words)
        number = {"value": value, "unit": unit, "source": source.format(**words)}
        yield {"what": name.format(**words).split(":")[0], "why": says, "error": error, **number}


def modelled_rows(case: Case) -> list[Row]:
    """Rows of what is modelled, from the sea to the objects."""
    return [*_sea(case), *_light(case), *_radar(case), *_receiver(case), *_boat(case), *_objects(case)]


def left_out_rows(case: Case) -> list[Row]:
    """Rows of what is left out, the scene's geometry first."""
    groups = (_no_geometry, _no_radar, _no_boat, _no_objects, _no_light, _no_scattering, _no_mean, _no_sea)
    return [row for group in groups for row in group(case)]


# ---------------------------------------------------------------------------------------------- what is modelled


def _sea(case: Case) -> Iterator[Row]:
    scene, sea, resolved = case.scene, case.scene.sea, case.resolved
    kind = {"linear": "linear", "choppy": "choppy (first-order Lagrangian)"}[sea.model]
    says = (
        f"{kind}, evolving{f', on a current of {sea.current_m_s:g} m/s' if sea.current_m_s > 0.0 else ''}; waves "
        f"longer than {2.0 * resolved.resolution_m:.3g} m resolved: {resolved.variance_share:.2%} of the variance, "
        f"{resolved.mean_square_slope_share:.0%} of the same spectra's mean square slope"
    )
    yield from case.row("sea", resolved.elevation_std, says)
    says = "azimuth is time: each column of the sea is meshed when the beam passes it"
    still = formulas.still_sea_error(case.waves, scanned_share(scene.radar) * scene.turn_duration_s)
    if scene.radar.scan == "staring":
        says = f"staring for {1e3 * scene.radar.stare_s:g} ms a map, of the sea as it is half-way"
        still = 0.0
    yield from case.row("scan", still, says)


def _light(case: Case) -> Iterator[Row]:
    tracing, scattering, radar = case.scene.tracing, case.scene.scattering, case.scene.radar
    says = {
        "facets": "a shadow ray to each facet that faces the antenna, for each antenna, traced by Sionna RT/Mitsuba",
        "horizon": "running maximum of the elevation angle, float64",
        "paths": "a line-of-sight path to each facet, for each antenna, by Sionna RT's PathSolver",
    }[tracing.tracer]
    if tracing.diffraction == "knife_edge":
        says += "; beyond a crest, and close above it, the field of two knife edges"
    hidden = formulas.shadowed_share(radar, 0.5 * case.resolved.mean_square_slope)
    yield from case.row("shadowing", 100.0 * hidden, says)

    says = f"{scattering.polarization}: {_scattering_words(case)}"
    if scattering.nrcs == "two_scale":
        yield from case.row("scattering", case.facing.modulation_db, says, of="facets' own echo", by=_TWO_SCALE)
    else:
        level = -float(db(formulas.mean_level(case.scene, case.middle_m)))
        yield from case.row("scattering", level, says, of="the mean echo", by=f"σ0 of {scattering.nrcs} below 1")

    time = scattering.decorrelation_time_s
    looks = formulas.looks(radar, time)
    says = f"complex Gaussian per facet, decorrelation time {1e3 * time:g} ms"
    yield from case.row("speckle", formulas.speckle_db(looks), says, looks=looks)

    speeds, own = [formulas.orbital_speed(case.waves)], ""
    says = "each facet's phase follows its water particle while the beam dwells on it"
    if scattering.doppler != "orbital":
        speeds.append(formulas.bragg_speed(radar.frequency_hz))
        own = f" and {speeds[1]:.2g} m/s of Bragg waves"
        says += "; Bragg waves of both directions run on it at their phase speed"
        says += ", breakers at theirs" if scattering.nrcs == "two_scale" and scattering.breaking else ""
    yield from case.row("motion", formulas.doppler_cycles(radar, math.hypot(*speeds)), says, water=speeds[0], own=own)


def _scattering_words(case: Case) -> str:
    scattering = case.scene.scattering
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


def _radar(case: Case) -> Iterator[Row]:
    radar, array, sigma = case.scene.radar, antenna_array(case.scene.radar), case.resolved.elevation_std
    paths, first = formulas.phase_paths(radar), formulas.first_antenna(radar)
    says = f"{radar.transmit} transmitter, {radar.interferogram} interferogram: p = {paths}"
    if array.whole and radar.transmit == "switched" and case.scene.retrieval.paths == "best":
        says += "; maps take p = 2 from neighbouring pulses, of which p = 1 tells the cycle"
    wrong, read = (sigma, "doubled") if paths == 2 else (0.5 * sigma, "halved")
    yield from case.row("mode", wrong, says, other=3 - paths, read=read)

    says = (
        f"{len(array.elements)}, {radar.antenna.pattern}, with sidelobes as far as ±{BEAMS_BEYOND:g} beams; "
        f"{first.azimuth_beamwidth_deg:.3g}° × {first.elevation_beamwidth_deg:.3g}°, {float(db(first.gain)):.3g} dBi"
    )
    if squint := common_squint_deg(radar):
        says += f"; squint {squint:.3g}°, known"
    if any(element.channel != 1.0 for element in array.elements):
        says += "; channels that are not alike, unknown to the retrieval"
    if (array.offsets != array.known_offsets).any():
        says += "; antennas that stand elsewhere than the retrieval assumes"
    yield from case.row("antennas", 100.0 * formulas.share_beyond(first, first.azimuth_beamwidth_deg, 1.0), says)

    says = f"rectangular pulse of {1e9 * radar.pulse_width_s:g} ns through a Gaussian filter"
    if radar.waveform == "chirp":
        says = (
            f"chirp of {1e6 * radar.pulse_width_s:g} µs over {1e-6 * radar.chirp_bandwidth_hz:g} MHz, matched filter "
            f"with {radar.compression_window} window; what comes before the transmitter is off is lost "
            f"(nearer than {blind_range_m(radar):.3g} m in part)"
        )
    cell = RangeResponse.of(radar).resolution_m
    yield from case.row("waveform", math.sqrt(case.resolved.mean_square_slope / 24.0) * cell, says, cell=cell)


def _receiver(case: Case) -> Iterator[Row]:
    radar, digital = case.scene.radar, case.scene.radar.receiver.chain == "digital"
    says = f"{'digital' if digital else 'ideal complex'} gates, {'thermal' if radar.noise else 'no'} noise"
    name, error, words = "receiver", 0.0, ""
    if radar.noise:
        snr = case.signal_to_noise(case.middle_m)
        words = f", echo {float(db(snr)):.2g} dB over the noise"
        error = formulas.noise_height_error(radar, snr, case.middle_m)
        if math.isinf(error):
            name, error = "receiver: without a baseline", formulas.noise_phase_error(radar, snr)
    yield from case.row(name, error, says, snr=words)
    if digital:
        yield from _converter(case)


def _converter(case: Case) -> Iterator[Row]:
    """The same number, modelled or not; automatic gain takes the near gate's echo for the strongest."""
    radar, receiver = case.scene.radar, case.scene.radar.receiver
    strongest = case.signal_to_noise(float(formulas.window(radar)[0])) * noise_power(radar)
    try:
        noise = formulas.quantisation_db(radar, formulas.full_scale_w(radar, strongest))
    except ValueError:  # settings of a receiver that is not used need not fit
        return
    says = "ideal complex gates; radar.receiver.chain = 'digital' has the converter"
    if receiver.chain == "digital":
        gain = "automatic gain" if receiver.gain == "agc" else f"full scale {receiver.full_scale_dbm:g} dBm"
        says = (
            f"{1e-6 * receiver.if_hz:g} MHz sampled at {1e-6 * receiver.adc_rate_hz:g} MS/s with {receiver.adc_bits} "
            f"bits, {gain}, saturation, digital down-conversion and decimation by {decimation(radar)}"
        )
    yield from case.row("analogue-to-digital conversion", noise, says, bits=receiver.adc_bits)


def _boat(case: Case) -> Iterator[Row]:
    platform = case.scene.platform
    moves, tilt = platform != PlatformSettings(), case.boat_tilt
    says = {
        "fixed": "steady" if platform.speed_m_s or platform.list_deg or platform.trim_deg else "at rest",
        "sinusoidal": "rolls, pitches, yaws and heaves in sines",
        "wave_following": f"{platform.length_m:g} m long, goes with the waves that the radar sees, without resonance",
        "file": "moves as recorded",
    }[platform.motion]
    says += f", {platform.speed_m_s:g} m/s" if platform.speed_m_s else ""
    says += "; sensors perfect" if platform.sensors == type(platform.sensors)() else "; its sensors err"
    yield from case.row("boat", case.middle_m * tilt if moves else 0.0, says, tilt=math.degrees(tilt) if moves else 0.0)


def _objects(case: Case) -> Iterator[Row]:
    radar, objects, over = case.scene.radar, case.scene.objects, list[float]()
    near, far = formulas.window(radar)[[0, -1]]
    for each in objects:
        if each.rcs_dbsm is not None:
            distance = float(np.clip(np.linalg.norm(each.position_m), near, far))
            level = formulas.mean_level(case.scene, distance)
            over.append(formulas.object_over_sea_db(radar, each.rcs_dbsm, level, distance))
    if objects:
        says = f"{len(objects)} hide the sea behind them, {len(over)} of them echo themselves"
        name, value = ("objects", max(over)) if over else ("objects: without echoes", float(len(objects)))
        yield from case.row(name, value, says)


# ---------------------------------------------------------------------------------------------- what is left out


def _no_geometry(case: Case) -> Iterator[Row]:
    radar, detail, resolved = case.scene.radar, case.scene.detail, case.resolved
    far, width = radar.range_m[1], sector_width(radar)
    says = "one bounce; the second is not traced, and that of mirrors not estimated"
    yield from case.row("multiple scattering", 100.0 * formulas.second_bounce_share(resolved.mean_square_slope), says)

    column = far * math.radians(antenna_array(radar).narrowest_beam_deg) / detail.columns_per_beam
    says = (
        f"its columns are {column:.2g} m wide at the far gate, its rungs {detail.facet_m:g} m apart; "
        f"the shortest resolved waves are {2.0 * resolved.resolution_m:.2g} m long"
    )
    name, errors = (
        "slopes of resolved waves that the mesh is too coarse for",
        (detail.power_error_db, detail.visible_error),
    )
    yield from case.row(name, detail.height_error_m, says, power=errors[0], visible=errors[1])

    drop = formulas.drop_m(far)
    yield from case.row("Earth curvature", drop, f"flat Earth: the drop at {far:g} m is {drop:.2g} m", far=far)

    if radar.scan == "turning" and width < 360.0:
        first = formulas.first_antenna(radar)
        beyond = 100.0 * formulas.share_beyond(first, first.azimuth_beamwidth_deg, BEAMS_BEYOND)
        says = (
            f"radar.sector_deg is {width:g}° wide: {100.0 - width / 3.6:.2g} % of the circle is neither meshed nor "
            f"traced, beyond {BEAMS_BEYOND:g} beams beside it"
        )
        yield from case.row("the rest of the circle", beyond, says)


def _no_radar(case: Case) -> Iterator[Row]:
    radar = case.scene.radar
    if radar.receiver.chain == "baseband":
        yield from _converter(case)
    if radar.scan == "staring":
        kept = math.exp(-((radar.stare_s / case.scene.scattering.decorrelation_time_s) ** 2))
        says = "each map of a staring antenna has speckle of its own"
        yield from case.row("speckle from one map to the next", kept, says)
        still, says = formulas.still_sea_error(case.waves, radar.stare_s), f"{1e3 * radar.stare_s:g} ms of a map"
        yield from case.row("the sea's motion within a map", still, f"it stands still for the {says}")


def _no_boat(case: Case) -> Iterator[Row]:
    scene, platform, tilt_deg = case.scene, case.scene.platform, math.degrees(case.boat_tilt)
    if platform == PlatformSettings():
        says = "it lies still; platform.motion = 'wave_following' lets it ride"
        yield from case.row("the boat's own motion", case.middle_m * case.boat_tilt, says, tilt=tilt_deg)
    elif platform.motion == "wave_following":
        says = "it follows the waves at once, as far as its size lets it: no resonance"
        yield from case.row("the boat's dynamics", tilt_deg, says)
    if platform.motion != "fixed" or platform.list_deg or platform.trim_deg:
        off = case.resolved.elevation_std * math.tan(case.boat_tilt)
        says = "the fan is laid on the mean sea; a crest lies off it by its height times the lean"
        yield from case.row("the waves' effect on where a leaning beam meets the sea", off, says)
    sailed = platform.speed_m_s * scene.turns * scene.turn_duration_s
    if sailed > 0.5 * scene.radar.range_m[1]:
        says = f"they stay centred on the origin, and the boat sails {sailed:.3g} m off it"
        yield from case.row("ground maps around the boat", sailed, says)


def _no_objects(case: Case) -> Iterator[Row]:
    objects, width = case.scene.objects, case.scene.radar.antenna.width_m
    nearest = min((float(np.linalg.norm(each.position_m)) for each in objects), default=0.0)
    if nearest > 0.0:
        behind = width * max(0.0, case.middle_m / nearest - 1.0)
        says = "an object hides what lies behind it from a point, however thin the object is"
        yield from case.row("the antennas' width", behind, says, width=width, nearest=nearest)
    if any(each.rcs_dbsm is not None for each in objects):
        says = "an object echoes by its own cross-section alone"
        yield from case.row("echoes between objects and the sea", float(db(_MIRROR_PATHS)), says)


def _no_light(case: Case) -> Iterator[Row]:
    scene, resolved = case.scene, case.resolved
    # From a crest to the shadow's end is at most a wave, half of one in the mean.
    to_shade = 2.0 * resolved.elevation_std / resolved.significant_steepness if resolved.significant_steepness else 0.0
    blur = formulas.edge_blur_m(link.wavelength(scene.radar), case.middle_m, to_shade)
    edge = f"knife edge (ITU-R P.526), {to_shade:.2g} m before the shade: half the peak's length"
    if scene.tracing.diffraction == "none":
        says = "geometric shadows; tracing.diffraction = 'knife_edge'"
        yield from case.row("diffraction at shadow edges", blur, says, edge=edge)
    else:
        says = (
            "a shadow answers with its crest's height, and the fringes above a crest pull heights beside it down; "
            "the stated error knows neither"
        )
        yield from case.row("what diffraction does to heights", blur, says, edge=edge)


def _no_scattering(case: Case) -> Iterator[Row]:
    scene, scattering, radar = case.scene, case.scene.scattering, case.scene.radar
    if scattering.doppler == "orbital":
        speed, says = (
            formulas.bragg_speed(radar.frequency_hz),
            "facets move with the water only; scattering.doppler = 'full'",
        )
        yield from case.row("the scatterers' own velocity", formulas.doppler_cycles(radar, speed), says, speed=speed)
    if scattering.nrcs != "two_scale":
        says = (
            f"scattering.nrcs = '{scattering.nrcs}' gives every facet that is seen its mean; 'two_scale' has them, "
            "and only it uses calibrated_to, breaking, hydrodynamic_modulation and inverse_wave_age"
        )
        yield from case.row("tilt, strain and breakers", math.hypot(case.facing.modulation_db, case.strain_db), says)
        return
    hidden, says = (
        formulas.shadows_of_short_waves(scene, case.resolved),
        "the mesh does not carry them; a tilt may turn away",
    )
    yield from case.row("shadows of waves that are not resolved", 100.0 * hidden, says)
    if scattering.breaking:
        shape = formulas.clutter_shape(radar, scattering.polarization, case.middle_m)
        says = "breakers are a share of each facet, not bursts that grow and fade"
        yield from case.row("a breaker's life", shape, says)
    else:
        says = "scattering.breaking = false: HH owes its mean to the calibration"
        yield from case.row("breakers", case.facing.breaking_db, says)
    if not scattering.hydrodynamic_modulation:
        says = "scattering.hydrodynamic_modulation = false: tilt alone modulates"
        yield from case.row("hydrodynamic modulation", case.strain_db, says)


def _no_mean(case: Case) -> Iterator[Row]:
    scene, scattering = case.scene, case.scene.scattering
    if scattering.mean_model is None:
        return
    model = MEAN_MODELS[scattering.mean_model]
    if scattering.extrapolate:
        states, band = model.sea_state, [1e-9 * each for each in model.frequency_hz]
        state = float(sea_state_from_wind(scattering.wind_speed_m_s))
        says = (
            f"scattering.extrapolate = true: {model.paper} holds for sea states {states[0]:g} to {states[1]:g} and "
            f"{band[0]:g} to {band[1]:g} GHz; this scene is sea state {state:.2g} at "
            f"{1e-9 * scene.radar.frequency_hz:g} GHz"
        )
        yield from case.row("the clutter model's own range", formulas.models_spread_db(scene), says)
    if not model.knows_wind_direction:
        says = f"{model.paper} is an average over directions; git, tsc and hybrid know them"
        yield from case.row("wind-direction contrast of the mean echo", formulas.wind_contrast_db(scene), says)
    (low, high), says = model.grazing_deg, "facets beyond take the value at the edge of its range"
    outside, name = 100.0 * formulas.outside_share(scene.radar, low, high), "the mean outside {low:g}–{high:g}° grazing"
    yield from case.row(name, outside, says, low=low, high=high, paper=model.paper)


def _no_sea(case: Case) -> Iterator[Row]:
    sea, resolved, facet = case.scene.sea, case.resolved, case.scene.detail.facet_m
    sigma, steepness, carried = resolved.elevation_std, resolved.significant_steepness, resolved.carried_share
    if sea.model == "linear":
        says = "waves are linear; sea.model = 'choppy' sharpens them"
        yield from case.row("sharper crests", formulas.second_order_error(sigma, steepness), says)
    else:
        says = "0 at the first Lagrangian order, unlike in a second-order sea of this height and peak"
        yield from case.row("skewness of the elevation", resolved.skewness_stokes, says)
    if facet > resolved.resolution_m:
        says = (
            f"facets are {facet:g} m apart, the waves' grid {resolved.resolution_m:.3g} m: neither the mesh nor the "
            "scattering has all of them; lower tracing.facet_m or coarsen sea.resolution_m"
        )
        name = "slopes of resolved waves shorter than {step:g} m along the look"
        yield from case.row(name, formulas.slopes_lost(case.waves, facet), says, step=2.0 * facet)
    if carried < _WELL_SAMPLED:
        says = (
            f"the periodic patch samples {carried:.0%} of a system's variance; the rest is spread over its other "
            "waves; raise sea.extent_m"
        )
        yield from case.row("the longest waves' place in the spectrum", sigma * math.sqrt(1.0 - carried), says)
    if steepness > _STEEPEST:
        says = (
            f"its significant height over the length of its peak is {steepness:.2g}; real seas stay below {_STEEPEST:g}"
        )
        yield from case.row("breaking, which this sea would do", 4.0 * sigma * (1.0 - _STEEPEST / steepness), says)
    if 4.0 * sigma > _HIGHEST * sea.depth_m:
        says = (
            f"its significant height is {4.0 * sigma / sea.depth_m:.2g} of the depth; real seas stay below "
            f"{_HIGHEST:g}, and troughs may reach below the bed"
        )
        yield from case.row("breaking on the bed, which this sea would do", 4.0 * sigma - _HIGHEST * sea.depth_m, says)
