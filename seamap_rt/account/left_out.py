"""What a run leaves out: why, or by which key it would be modelled, and the error that this costs now."""

from __future__ import annotations

from ..radar.scan import BEAMS_BEYOND, sector_width
from . import radar_errors, sea_errors
from .basis import Basis
from .left_out_of_radar import left_out_of_boat_and_objects, left_out_of_radar
from .left_out_of_scattering import left_out_of_scattering
from .row import Row, metres_of_height, share

_CARRIED = 0.97
_BREAKING_STEEPNESS = 0.06  # Hs over the peak's length
_BREAKING_DEPTH = 0.6  # Hs over the depth


def left_out_rows(basis: Basis) -> list[Row]:
    """All rows, the scene's geometry first."""
    return [
        Row(
            "multiple scattering",
            "one bounce; the second is not traced",
            "0.5 % of the echo if the sea scatters evenly; up to 2 % along the waves and 8 % across them by mirrors",
            "choppy_sea by Sionna RT's path solver (`validation/light/paths.py`); twice to four times that where a "
            "path and its reverse add in phase",
        ),
        _mesh(basis),
        _curvature(basis),
        *_rest_of_the_circle(basis),
        *left_out_of_radar(basis),
        *left_out_of_boat_and_objects(basis),
        *left_out_of_scattering(basis),
        *_left_out_of_sea(basis),
    ]


def _mesh(basis: Basis) -> Row:
    detail, width = basis.scene.detail, basis.far_column_m
    why = (
        f"its columns are {width:.2g} m wide at the far gate, its rungs {detail.facet_m:g} m apart; "
        f"the shortest resolved waves are {2.0 * basis.resolved.resolution_m:.2g} m long"
    )
    return Row(
        "slopes of resolved waves that the mesh is too coarse for",
        why,
        f"{detail.height_error_m:.2g} m rms of the maps' heights, {detail.power_error_db:.2g} dB of power, "
        f"{detail.visible_error:.1%} of what is visible",
        "the model by which the mesh was sized (`validation/light/detail.py`), cells more than half visible",
    )


def _curvature(basis: Basis) -> Row:
    far = basis.scene.radar.range_m[1]
    drop = radar_errors.drop_m(far)
    why = f"flat Earth: the drop at {far:g} m is {drop:.2g} m"
    return Row("Earth curvature", why, f"{drop:.2g} m of height at {far:.0f} m", "d²/2R, 4/3 of the Earth's radius")


def _rest_of_the_circle(basis: Basis) -> list[Row]:
    radar = basis.scene.radar
    width = sector_width(radar)
    if radar.scan == "staring" or width >= 360.0:
        return []
    first = radar_errors.first_antenna(radar)
    beyond = radar_errors.share_beyond(first, first.azimuth_beamwidth_deg, BEAMS_BEYOND)
    why = (
        f"radar.sector_deg is {width:g}° wide: {share(1.0 - width / 360.0)} of the circle is neither meshed nor "
        f"traced, beyond {BEAMS_BEYOND:g} beams beside it"
    )
    error = f"{share(beyond)} of the echo, from further aside"
    return [Row("the rest of the circle", why, error, "integral of the two-way azimuth pattern")]


def _left_out_of_sea(basis: Basis) -> list[Row]:
    scene, resolved, rows = basis.scene, basis.resolved, list[Row]()
    second = metres_of_height(sea_errors.second_order_error(resolved.elevation_std, resolved.significant_steepness))
    if scene.sea.model == "linear":
        why = "waves are linear; sea.model = 'choppy' sharpens them"
        rows.append(Row("sharper crests", why, second, "kσ² of a narrow-banded sea (Longuet-Higgins 1963)"))
    else:
        why = (
            "0 at the first Lagrangian order; a narrow-banded second-order sea of this height and peak would have "
            f"{resolved.skewness_stokes:.2g}"
        )
        error = f"{resolved.skewness_stokes:.2g} of skewness"
        rows.append(Row("skewness of the elevation", why, error, "3kσ (Longuet-Higgins 1963)"))
    if scene.detail.facet_m > resolved.resolution_m:
        lost = sea_errors.slopes_lost(basis.waves, scene.detail.facet_m)
        why = (
            f"facets are {scene.detail.facet_m:g} m apart, the waves' grid {resolved.resolution_m:.3g} m: neither "
            "the mesh nor the scattering has all of them; lower tracing.facet_m or coarsen sea.resolution_m"
        )
        rows.append(
            Row(
                f"slopes of resolved waves shorter than {2.0 * scene.detail.facet_m:g} m along the look",
                why,
                f"{lost:.2g} rms of slope",
                "half their mean square slope",
            )
        )
    if resolved.carried_share < _CARRIED:
        astray = resolved.elevation_std * (1.0 - resolved.carried_share) ** 0.5
        why = (
            f"the periodic patch samples {resolved.carried_share:.0%} of a system's variance; the rest is spread "
            "over its other waves; raise sea.extent_m"
        )
        error = f"{metres_of_height(astray)} at other wavelengths"
        rows.append(Row("the longest waves' place in the spectrum", why, error, "σ √(1 − share)"))
    return rows + _breaking(basis)


def _breaking(basis: Basis) -> list[Row]:
    resolved, depth, rows = basis.resolved, basis.scene.sea.depth_m, list[Row]()
    height, steepness = 4.0 * resolved.elevation_std, resolved.significant_steepness
    if steepness > _BREAKING_STEEPNESS:
        why = (
            f"its significant height over the length of its peak is {steepness:.2g}; real "
            f"seas stay below about {_BREAKING_STEEPNESS:g}"
        )
        error = f"{height * (1.0 - _BREAKING_STEEPNESS / steepness):.2g} m of significant height too much"
        rows.append(Row("breaking, which this sea would do", why, error, "height over that limit"))
    if height > _BREAKING_DEPTH * depth:
        why = (
            f"its significant height is {height / depth:.2g} of the depth; real "
            f"seas stay below about {_BREAKING_DEPTH:g}, and troughs may reach below the bed"
        )
        error = f"{height - _BREAKING_DEPTH * depth:.2g} m of significant height too much"
        rows.append(Row("breaking on the bed, which this sea would do", why, error, "height over that limit"))
    return rows
