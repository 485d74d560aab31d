"""What a run leaves out of light and scattering."""

from __future__ import annotations

from ..scattering import MEAN_MODELS, MeanModel, sea_state_from_wind
from . import light_errors, radar_errors
from .basis import Basis
from .row import Row, decibels, share


def left_out_of_scattering(basis: Basis) -> list[Row]:
    """Rows about diffraction, the scatterers and the mean model."""
    scattering = basis.scene.scattering
    rows = [_diffraction(basis)]
    if scattering.doppler == "orbital":
        speed = light_errors.bragg_speed(basis.scene.radar.frequency_hz)
        cycles = radar_errors.doppler_cycles(basis.scene.radar, speed)
        rows.append(
            Row(
                "the scatterers' own velocity",
                "facets move with the water only; scattering.doppler = 'full'",
                f"{speed:.2g} m/s, {cycles:.2g} cycles of phase in a dwell",
                "phase speed of Bragg waves at grazing; 2vT/λ",
            )
        )
    rows += _of_two_scale(basis) if scattering.nrcs == "two_scale" else [_of_a_mean(basis)]
    model = None if scattering.mean_model is None else MEAN_MODELS[scattering.mean_model]
    return rows if model is None else rows + _of_the_model(basis, model)


def _diffraction(basis: Basis) -> Row:
    if basis.scene.tracing.diffraction == "none":
        return Row(
            "diffraction at shadow edges",
            "geometric shadows; an edge blurs by about 0.5 m at X band; tracing.diffraction = 'knife_edge'",
            "0.4–3 dB of the echo at 50–400 m",
            "choppy_sea, `validation/light/diffraction.py`",
        )
    return Row(
        "what diffraction does to heights",
        "a shadow answers with its crest's height, and the fringes above a crest pull heights beside it down; "
        "the stated error knows neither",
        "0.11 m rms of height",
        "choppy_sea, `validation/scattering/scattering_speed.py`: 0.139 m with it, 0.090 m without",
    )


def _of_two_scale(basis: Basis) -> list[Row]:
    scattering = basis.scene.scattering
    hidden = light_errors.shadows_of_short_waves(basis.scene, basis.resolved)
    rows = [
        Row(
            "shadows of waves that are not resolved",
            "the mesh does not carry them; a tilt may turn away",
            f"{share(hidden)} of the window answers that they would hide",
            "Smith (1967) with the slopes of those that tilt facets and without; geometric shadows",
        )
    ]
    at = f"at {basis.middle_m:.0f} m"
    if scattering.breaking:
        rows.append(
            Row(
                "a breaker's life",
                "breakers are a share of each facet, not bursts that grow and fade",
                "echo too smooth by 5–10 × in HH, 1.4 × in VV",
                "shape parameter on choppy_sea against Watts & Wicks (1990), `validation/scattering/texture.py`",
            )
        )
    else:
        why = "scattering.breaking = false: HH owes its mean to the calibration"
        error = decibels(basis.facing.breaking_db, f"theory's mean echo {at}")
        rows.append(Row("breakers", why, error, "their share over slopes that face the antenna"))
    if not scattering.hydrodynamic_modulation:
        why = "scattering.hydrodynamic_modulation = false: tilt alone modulates"
        error = decibels(basis.strain_db, "facets' own echo")
        rows.append(Row("hydrodynamic modulation", why, error, "4.5 × rms strain (Alpers & Hasselmann 1978)"))
    return rows


def _of_a_mean(basis: Basis) -> Row:
    scattering = basis.scene.scattering
    return Row(
        "tilt, strain and breakers",
        f"scattering.nrcs = '{scattering.nrcs}' gives every facet that is seen its mean; 'two_scale' has them, "
        "and only it asks for calibrated_to, breaking, hydrodynamic_modulation and inverse_wave_age",
        decibels((basis.facing.modulation_db**2 + basis.strain_db**2) ** 0.5, "facets' own echo"),
        f"rms at {basis.middle_m:.0f} m by two-scale theory and by 4.5 × rms strain",
    )


def _of_the_model(basis: Basis, model: MeanModel) -> list[Row]:
    scene, scattering, rows = basis.scene, basis.scene.scattering, list[Row]()
    at = f"the mean echo at {basis.middle_m:.0f} m"
    if scattering.extrapolate:
        why = (
            f"scattering.extrapolate = true: {model.paper} holds for sea states {model.sea_state[0]:g} to "
            f"{model.sea_state[1]:g} and {1e-9 * model.frequency_hz[0]:g} to "
            f"{1e-9 * model.frequency_hz[1]:g} GHz; this scene is sea state "
            f"{float(sea_state_from_wind(scattering.wind_speed_m_s)):.2g} at "
            f"{1e-9 * scene.radar.frequency_hz:g} GHz"
        )
        error = decibels(light_errors.models_spread_db(scene), at)
        rows.append(Row("the clutter model's own range", why, error, "spread of the four models, run on alike"))
    if not model.knows_wind_direction:
        why = f"{model.paper} is an average over directions; git, tsc and hybrid know them"
        error = decibels(light_errors.wind_contrast_db(scene), f"{at}, up-wind over down-wind")
        rows.append(Row("wind-direction contrast of the mean echo", why, error, "mean of the models that know it"))
    low, high = model.grazing_deg
    outside = light_errors.outside_share(scene.radar, low, high)
    rows.append(
        Row(
            f"the mean outside {low:g}–{high:g}° grazing",
            "facets beyond take the value at the edge of its range",
            f"{share(outside)} of the window",
            "where mean sea level is seen from beyond that range",
        )
    )
    return rows
