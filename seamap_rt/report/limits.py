"""What a run modelled, at what cost, and what it left out, at what error: for `metrics.json`, the report and the shell.

Each row holds one number, for one scene and its resolved sea: a closed form of the package that owns its subject, or
what one of the simulation's own models says. A row whose number is not finite does not hold for the scene, and is left
out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from ..conventions import db
from ..echoes.response import beam_truncation, truncation_error_m, truncation_share
from ..echoes.slow_time import interpolation_loss
from ..echoes.speckle import speckle_truncation
from ..physics.shadowing import arrival_error_mrad, earth_drop_m, edge_blur_m, second_bounce_share
from ..radar import link, precision
from ..radar.receiver import phase_drift_in_pulse
from ..radar.scan import BEAMS_BEYOND, sector_width
from ..scattering import MEAN_MODELS, mean_level, sea_state_from_wind
from ..scattering.bragg import bragg_speed
from ..scattering.mean_models import models_spread_db, wind_contrast_db
from ..scene import Scene
from ..sea import ResolvedSea
from ..settings import PlatformSettings
from .modelled import (
    BENT,
    BURSTS,
    CYCLES,
    GROUPS,
    HEIGHT,
    MEAN_ECHO,
    OWN_ECHO,
    PATTERN,
    STILL,
    TILT,
    TWO_SCALE,
    Case,
    Row,
    account_lines,
    converter,
    costed,
    patches,
    row,
)

__all__ = ["account_lines", "costed", "modelled", "not_modelled"]

_WELL_SAMPLED = 0.97  # share of a system's variance from which on the patch's wavenumbers hold it
_STEEPEST, _HIGHEST = 0.06, 0.6  # of real seas, about: Hs over the length of the peak, Hs over the depth
_SQUARES = 101  # a side, in which the circle is shared out
_MIRROR_PATHS = 16.0  # (1 + |ρ|)⁴, |ρ| = 1: a direct and a reflected path, there and back
_IMAGES = "mean square of the spline's images (Unser 1999)"
_CRESTS = "of a narrow-banded sea (Longuet-Higgins 1963)"


def modelled(scene: Scene, resolved: ResolvedSea) -> list[Row]:
    """Rows of what was modelled, how, and the error of leaving it out: what, why, error, value, unit, source."""
    return _finite(Case(scene, resolved), GROUPS)


def not_modelled(scene: Scene, resolved: ResolvedSea) -> list[Row]:
    """Rows of what was not, why or by which key it would be, and the error that this costs; keys as of `modelled`."""
    return _finite(Case(scene, resolved), _LEFT_OUT)


def _finite(case: Case, groups: Sequence[Callable[[Case], Iterator[Row]]]) -> list[Row]:
    return [row for group in groups for row in group(case) if math.isfinite(row["value"])]


def _no_geometry(case: Case) -> Iterator[Row]:
    radar, detail, array = case.radar, case.scene.detail, case.array
    far, width, bounced = radar.range_m[1], sector_width(radar), second_bounce_share(case.resolved.mean_square_slope)
    error, source = "% of what scatters evenly meets the sea again", "view factors of resolved waves"
    says = "the second bounce is not traced, and that of mirrors not estimated"
    yield row("multiple scattering", 100.0 * bounced, error, source, says)
    name, source = "slopes of resolved waves that the mesh is too coarse for", "the mesh sizing model (`mesh.sizing`)"
    cost = f"{detail.power_error_db:.2g} dB of power, {detail.visible_error:.1%} of what is visible"
    says = f"rungs {detail.facet_m:g} m apart, {detail.columns_per_beam} columns a beam; lower tracing.height_error_m"
    yield row(name, detail.height_error_m, f"m rms of the maps' heights, {cost}", source, says)
    yield from _truncated(case)
    error, source = f"m of height at {far:.0f} m", "d²/2R, 4/3 of the Earth's radius"
    yield row("Earth curvature", earth_drop_m(far), error, source, "the Earth is flat")
    if radar.scan == "turning" and width < 360.0:
        beyond, error = 100.0 * array.first_antenna.share_beyond(BEAMS_BEYOND), "% of the echo, from further aside"
        unseen = f"{100.0 - width / 3.6:.2g} % of the circle is neither meshed nor traced"
        says = f"radar.sector_deg is {width:g}° wide: {unseen}, beyond {BEAMS_BEYOND:g} beams beside it"
        yield row("the rest of the circle", beyond, error, PATTERN, says)
    if radar.receiver.chain != "digital":
        yield converter(case)
    if radar.transmitter == "magnetron" and radar.frequency_jitter_hz:
        lost, error = phase_drift_in_pulse(radar) ** 2, "1 of the coherence between pulses"
        says = "phases that the carrier's jitter turns across a pulse: a gate's facets take that of its middle"
        yield row("a magnetron's jitter within a pulse", lost, error, "(2π δ s)², s of a gate's delays", says)
    if radar.scan == "staring":
        kept = math.exp(-((radar.stare_s / case.scene.scattering.decorrelation_time_s) ** 2))
        name, source = "speckle from one map to the next", "exp(−(τ/τc)²) of two pulses one map apart"
        yield row(name, kept, "1 of correlation", source, "each map of a staring antenna has speckle of its own")
        still, says = case.waves.still_sea_error(radar.stare_s), f"for the {1e3 * radar.stare_s:g} ms of a map"
        yield row("the sea's motion within a map", still, HEIGHT, STILL, f"it stands still {says}")


def _truncated(case: Case) -> Iterator[Row]:
    """What comes from further aside, or in range, than facets are summed, and what the pulses between nodes miss."""
    radar, sigma = case.radar, case.resolved.elevation_std
    share = truncation_share(sigma, case.scene.tracing.height_error_m)
    aside = "" if radar.scan == "staring" else f" within {beam_truncation(radar, share):.3g} beams to either side"
    says = f"facets are summed{aside} up to {float(db(share)):.2g} dB of the power; lower tracing.height_error_m"
    error, source = "m rms of height, of a single sample", "√p σ, p of the power (`echoes.truncation`)"
    name = "the beam's outer sides and the pulse's flanks"
    yield row(name, truncation_error_m(radar, sigma, share), error, source, says)
    missed = interpolation_loss(share)
    says = f"nodes lie so far apart that up to {float(db(missed)):.2g} dB of the power is missed between them; "
    says += "lower tracing.height_error_m"
    source = "√p σ, p of the power (`echoes.slow_time`)"
    yield row("pulses between slow-time nodes", math.sqrt(missed) * sigma, error, source, says)
    lost, source = speckle_truncation(share), "p σ, p of the power (`echoes.truncation.speckle_truncation`)"
    says = f"speckle's modes hold all but {float(db(lost)):.2g} dB of what the beam hears; lower tracing.height_error_m"
    yield row("how speckle goes on in its weakest modes", lost * sigma, "m rms of heights' errors", source, says)


def _no_boat(case: Case) -> Iterator[Row]:
    scene, boat, tilt = case.scene, case.scene.platform, case.boat_tilt
    if boat == PlatformSettings():
        error, source = f"{HEIGHT} {case.place}, were it unknown", TILT.format(math.degrees(tilt))
        says = "it lies still; platform.motion = 'wave_following' lets it ride"
        yield row("the boat's own motion", case.middle_m * tilt, error, source, says)
    elif boat.motion == "wave_following":
        error, source = "° rms of tilt without them; with them not known", "least-squares plane of the waves"
        yield row("the boat's dynamics", math.degrees(tilt), error, source, "it follows the waves without resonance")
    if boat.motion != "fixed" or boat.list_deg or boat.trim_deg:
        name, source = "the waves' effect on where a leaning beam meets the sea", "σ × tan of the lean"
        off, says = case.resolved.elevation_std * math.tan(tilt), "the fan is laid on the mean sea"
        yield row(name, off, "m rms of position", source, says)
    sailed = boat.speed_m_s * scene.turns * scene.turn_duration_s
    if sailed > 0.5 * case.radar.range_m[1]:
        says = "they stay centred on the origin"
        yield row("ground maps around the boat", sailed, "m of position at the end", "speed × time", says)

    objects, width = scene.objects, case.radar.antenna.width_m
    nearest = min((float(np.linalg.norm(each.position_m)) for each in objects), default=0.0)
    if nearest > 0.0:
        behind, error = width * max(0.0, case.middle_m / nearest - 1.0), f"m of half shadow {case.place}"
        source = f"aperture of {width:g} m past an object at {nearest:.2g} m"
        yield row("the antennas' width", behind, error, source, "an object hides what lies behind it from a point")
    if any(each.rcs_dbsm is not None for each in objects):
        name, error = "echoes between objects and the sea", "dB of an object's echo, at most"
        says = "an object echoes by its own cross-section alone"
        yield row(name, float(db(_MIRROR_PATHS)), error, "bound of a mirror (Kerr 1951)", says)

    yield from _diffraction(case)
    yield from _unresolved_shadows(case)


def _diffraction(case: Case) -> Iterator[Row]:
    """What crests do to the light that passes over them."""
    scene = case.scene
    angle, held = 1e-3 * arrival_error_mrad("VV", scene.wavelength_m), scene.resolved_retrieval.diffraction_mrad
    hidden = link.shadowed_share(case.radar, case.resolved.look_slope_variance)
    bent = math.sqrt(hidden) / math.hypot(1.0 / (angle * case.middle_m), 1.0 / max(case.resolved.elevation_std, 1e-9))
    error, source = f"m rms of height {case.place}", "maps with knife edges; full waves turn cells more, HH most"
    if scene.tracing.diffraction != "none":
        says = "a shadow answers with its crest's height, and fringes pull heights down; the stated error holds "
        says += "so much" if held else "nothing of it"
        yield row("what diffraction does to heights", bent, error, source, says)
        return
    says = f"rays are straight, and the stated error holds {'so much' if held else 'nothing of it'}; "
    says += "tracing.diffraction = 'knife_edge'"
    yield row("diffraction beside crests", bent, error, source, says)
    to_shade = 0.5 * case.resolved.peak_length  # from a crest: at most a wave, half of one in the mean
    blur = edge_blur_m(scene.wavelength_m, case.middle_m, to_shade)
    source = f"knife edge (ITU-R P.526), {to_shade:.2g} m before the shade: half the peak's length"
    error = f"m of height {case.place}, over which an edge fades"
    yield row("diffraction at shadow edges", blur, error, source, "geometric shadows")


def _unresolved_shadows(case: Case) -> Iterator[Row]:
    """What they hide, less what bends into them; of light's shadows, what bends into them."""
    shadows, kept, hidden = case.scene.tracing.unresolved_shadowing, case.shadow_power, case.hidden_by_tilts
    polarization = case.scene.scattering.polarization
    if shadows == "none":
        name, error = "shadows of waves that are not resolved", "% of the window answers from them, weighed by power"
        says = f"light would lose {hidden:.2g} %, but {kept:.0%} of its power bends into them in {polarization}; "
        says += "off, for by wave optics that moves no map: tracing.unresolved_shadowing = 'fresnel'"
        yield row(name, hidden * (1.0 - kept), error, BENT, says)
    elif shadows == "smith":
        name, error = (
            "diffraction at shadows of waves that are not resolved",
            "% of the window does not answer that would",
        )
        says = f"they hide as from light; in {polarization} {kept:.0%} of the power bends into them ('fresnel')"
        yield row(name, hidden * kept, error, BENT, says)


def _no_scattering(case: Case) -> Iterator[Row]:
    scattering, radar, own_echo = case.scene.scattering, case.radar, f"{OWN_ECHO} {case.place}"
    if scattering.doppler == "orbital":
        speed, says = bragg_speed(radar.frequency_hz), "facets move with the water only; scattering.doppler = 'full'"
        cycles, source = precision.doppler_cycles(radar, speed), f"2vT/λ, v = {speed:.2g} m/s of Bragg waves"
        yield row("the scatterers' own velocity", cycles, CYCLES, source, says)
    if scattering.nrcs != "two_scale":
        spread, source = math.hypot(case.facing.modulation_db, case.strain_db), f"{TWO_SCALE}; 4.5 × rms strain"
        says = "what is seen has the mean; scattering.nrcs = 'two_scale' has them, and alone uses their keys"
        yield row("tilt, strain and breakers", spread, own_echo, source, says)
        return
    if scattering.breaking and not scattering.texture:
        yield patches(
            case, "breakers gather on the resolved waves alone; scattering.texture = true has patches of them"
        )
    if scattering.breaking and not scattering.has_sea_spikes:
        says = "breakers are a share of each facet; scattering.sea_spikes = true makes them bursts that grow and fade"
        yield row("a breaker's life", case.clutter_shape, f"{BURSTS} {case.place}", "Watts & Wicks (1990)", says)
    elif not scattering.breaking:
        says = "scattering.breaking = false: HH owes its mean to the calibration"
        yield row("breakers", case.facing.breaking_db, f"dB of theory's mean echo {case.place}", TWO_SCALE, says)
    if not scattering.hydrodynamic_modulation:
        source = "4.5 × rms strain (Alpers & Hasselmann 1978)"
        says = "scattering.hydrodynamic_modulation = false: tilt alone modulates"
        yield row("hydrodynamic modulation", case.strain_db, own_echo, source, says)


def _no_mean(case: Case) -> Iterator[Row]:
    scattering, radar = case.scene.scattering, case.radar
    if scattering.mean_model is None:
        return
    model, middle = MEAN_MODELS[scattering.mean_model], (scattering, math.degrees(case.grazing), radar.frequency_hz)
    error, (low, high) = f"{MEAN_ECHO} {case.place}", model.grazing_deg
    if scattering.extrapolate:
        here = f"sea state {float(sea_state_from_wind(scattering.wind_speed_m_s)):.2g} at {1e-9 * middle[2]:g} GHz"
        name, source = "the clutter model's own range", "spread of the mean models, extrapolated alike"
        says = f"scattering.extrapolate = true: {model.paper} holds for {model.range_words}; this scene is {here}"
        yield row(name, models_spread_db(*middle), error, source, says)
    elif (held := model.nearest_wind(scattering.wind_speed_m_s)) != scattering.wind_speed_m_s:
        name, source = f"the clutter model beyond {held:.3g} m/s, where theory goes on", "its formula, let run on"
        run_on = mean_level(scattering.model_copy(update={"extrapolate": True}), *middle[1:])
        says = f"{model.paper} holds to {held:.3g} m/s: its mean there, times the growth of theory's from there on"
        yield row(name, abs(float(db(run_on / case.level(case.middle_m)))), error, source, says)
    if scattering.nrcs != "two_scale" and not model.knows_wind_direction:
        name, error = "wind-direction contrast of the mean echo", f"{error}, up-wind over down-wind"
        says = f"{model.paper} is an average over directions; git, tsc and hybrid, and two_scale, know them"
        yield row(name, wind_contrast_db(*middle), error, "mean of models", says)
    outside, source = 100.0 * link.share_outside(radar, low, high), f"grazing angles of {model.paper}"
    name, says = f"the mean outside {low:g}–{high:g}° grazing", "facets beyond take the value at the edge of its range"
    yield row(name, outside, "% of the window", source, says)


def _record_limits(case: Case) -> Iterator[Row]:
    """What a record of the sea does not hold."""
    from ..io.recorded_sea import recorded_sea

    file, resolved, far = recorded_sea(case.scene.sea.file), case.resolved, case.radar.range_m[1]
    says = f"frames {file.step_s:.3g} s and points {file.spacing_m:.3g} m apart; between them six frames and a spline"
    source = "Lagrange's and the spline's error, wave by wave"
    yield row("the sea between a record's frames", resolved.elevation_error, HEIGHT, source, says)
    if resolved.filled_m:
        name, error = "the sea in a record's gaps", "m rms of height in the middle of the widest"
        says = f"gaps of up to {resolved.filled_m:.2g} m, of the frames looked at, are filled, bent as little as can be"
        yield row(name, resolved.filled_error, error, "a thin plate across a strip, wave by wave", says)
    if not file.periodic:
        says = f"the water of waves longer than the patch of {file.side_m:.4g} m flows to and fro by none of it"
        source, error = "means of its frames", "% of the variance"
        yield row("the flow of waves longer than a record's patch", 100.0 * file.long_share, error, source, says)
        x, y = np.meshgrid(*2 * (np.linspace(-far, far, _SQUARES),))
        circle = np.hypot(x, y) <= far
        unknown = 100.0 * float(np.mean(~file.holds(x[circle], y[circle])))
        goes_on = {"level": "the sea goes on level", "mirrored": "the patch goes on mirrored"}
        says = f"{goes_on.get(case.scene.sea.beyond, 'it ends')} beyond {max(file.reach_m, 0.0):.3g} m, unjudged"
        source, error = "the record's own edges, less a rim", "% of the circle is not the record's sea"
        yield row("the sea beyond the record", unknown, error, source, says)


def _no_sea(case: Case) -> Iterator[Row]:
    sea, resolved, facet = case.scene.sea, case.resolved, case.scene.detail.facet_m
    height, carried = 4.0 * resolved.elevation_std, resolved.carried_share
    if sea.model == "linear":
        source, says = f"kσ² {_CRESTS}", "waves are linear, for on choppy_sea maps err by six times this; "
        says += "sea.model = 'choppy' sharpens them"
        yield row("sharper crests", resolved.second_order_std, HEIGHT, source, says)
    elif sea.model == "choppy":
        source, says = f"3kσ {_CRESTS}", "0 at the first Lagrangian order"
        yield row("skewness of the elevation", resolved.skewness_stokes, "1 of skewness", source, says)
    elif sea.model == "recorded":
        yield from _record_limits(case)
    if sea.model != "recorded" and resolved.elevation_std > 0.0:
        faster = 100.0 * (2.0 * math.pi / resolved.peak_length * resolved.elevation_std) ** 2
        error, source = "% of the peak's speed", "½ (ka)² of deep water (Stokes 1847), a² = 2σ²"
        says = "drawn waves do not feel each other, for up to Hs/λ 1/30 forecasts of 20 s lose 0.01 of correlation; "
        says += "seamap-rt sea --nonlinear writes a sea that does, once, for sea.model = 'recorded'"
        yield row("waves that run faster where they are steep", faster, error, source, says)
    if sea.model != "recorded" and resolved.elevation_error > 0.0:
        says = f"splines, whose slopes err by {resolved.slope_error:.2g} rms; lower tracing.height_error_m"
        yield row("waves between the points of their grid", resolved.elevation_error, HEIGHT, _IMAGES, says)
    if facet > resolved.resolution_m:
        name = f"slopes of resolved waves shorter than {2.0 * facet:g} m along the look"
        says = "neither the mesh nor the scattering has all of them; lower tracing.facet_m or coarsen sea.resolution_m"
        yield row(name, case.waves.slopes_lost(facet), "1 rms of slope", "the sea's spectrum", says)
    if carried < _WELL_SAMPLED:
        name, elsewhere = "the longest waves' place in the spectrum", 0.25 * height * math.sqrt(1.0 - carried)
        says = f"the periodic patch samples {carried:.0%} of a system's variance; raise sea.extent_m"
        yield row(name, elsewhere, f"{HEIGHT} at other wavelengths", "σ √(1 − share)", says)
    for name, of, length, most in (
        ("breaking, which this sea would do", "the peak's length", resolved.peak_length, _STEEPEST),
        ("breaking on the bed, which this sea would do", "the depth", sea.depth_m, _HIGHEST),
    ):
        if height > most * length:
            error, source = "m of significant height too much", "height over that limit"
            says = f"significant height is {height / length:.2g} of {of}; real seas stay below {most:g}"
            yield row(name, height - most * length, error, source, says)


_LEFT_OUT = (_no_geometry, _no_boat, _no_scattering, _no_mean, _no_sea)  # in the order of the account
