"""The sea as an eye at the mast's top would see it, by Mitsuba: a picture of the surface that the radar looks at.

The picture shows what was computed. The resolved waves are geometry; the ripples below their resolution are not made
up but blur the mirror: a Gaussian slope distribution (Cox & Munk 1954) is Beckmann's microfacet distribution
(Walter et al. 2007) of α² = mean square slope, both axes together. The water mirrors the sky by Fresnel's law
(n = 1.34) and shows its own dim blue-green. The sky is clear (Hošek & Wilkie 2012) and its sun has no disc, because
glints of glints would be specks. The Earth is flat.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..compute.backend import prepare
from ..conventions import unit_from_azimuth
from ..mesh.surface import as_trimesh
from .illumination import mitsuba, mitsuba_mesh

Elevation = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]

_REFRACTIVE_INDEX = 1.34  # sea water in visible light
_BODY = (0.012, 0.080, 0.090)  # red, green, blue reflectance of the water's body; the sun's share of its light included
_BOUNCES = 2  # of light between waves
_EXPOSURE = 0.35  # of the picture's geometric mean

# The fan of the mesh. Ranges are in camera heights, so that a picture's lines mean the same from any mast.
_NEAREST = 0.25
_WAVES_FADE_FROM, _WAVES_END = 400.0, 800.0  # 2.5 and 1.25 mrad below the horizon, 4 and 2 lines: not seen
_HORIZON = 1e5
_RANGE_SPACING, _RANGE_GROWTH = 0.1, 0.005  # m, and share of the range where that is more
_LINES_PER_COLUMN = 0.7  # the fan's radial lines, per column of the picture
_MARGIN_DEG = 10.0  # beside the picture, for what the water mirrors
_STEEPEST_DEG = 75.0  # below level; the mesh leaves the mast's foot out


@dataclass(frozen=True)
class View:
    """A camera over x = y = 0. Its horizontal field of view spans the picture's width; size is (columns, rows)."""

    height_m: float = 5.0  # above mean sea level
    azimuth_deg: float = 270.0  # looked to, clockwise from north
    field_of_view_deg: float = 60.0
    tilt_deg: float = 6.0  # of the optical axis, below level
    size: tuple[int, int] = (1600, 700)

    @property
    def focal_length(self) -> float:
        """Pixels."""
        return 0.5 * self.size[0] / np.tan(np.radians(0.5 * self.field_of_view_deg))

    @property
    def lowest_deg(self) -> float:
        """How far below level the middle of the picture's last line looks."""
        return self.tilt_deg + float(np.degrees(np.arctan(0.5 * self.size[1] / self.focal_length)))

    @property
    def widest_deg(self) -> float:
        """How far beside the middle the picture's lower corners look: more than half the field of view."""
        tilt, down = np.radians(self.tilt_deg), 0.5 * self.size[1]
        ahead = self.focal_length * np.cos(tilt) - down * np.sin(tilt)
        return float(np.degrees(np.arctan2(0.5 * self.size[0], ahead)))


@dataclass(frozen=True)
class Sky:
    """A clear sky. Turbidity is 2 in very clear air, 3 on a clear day, 6 in haze."""

    sun_azimuth_deg: float = 225.0
    sun_elevation_deg: float = 18.0
    turbidity: float = 2.5


def render_from_mast(
    elevation: Elevation,
    view: View | None = None,
    sky: Sky | None = None,
    *,
    unresolved_mss: float = 0.02,
    samples: int = 25,
    seed: int = 0,
) -> NDArray[np.uint8]:
    """The sea seen from the mast: (rows, columns, 3) sRGB.

    elevation(x, y): height above mean sea level [m] at points [m] of any shape, at one moment; of a realised sea it is
    `lambda x, y: sea.elevation(x, y, t)`. unresolved_mss: mean square slope of what it leaves out, both axes together.
    samples: rays a pixel, rounded up to a square. The same seed gives the same picture. Raises ValueError for a camera
    under water or one that looks down at its own mast.
    """
    view, sky = view or View(), sky or Sky()
    _check(elevation, view, sky, unresolved_mss, samples)
    backend = prepare()
    mi = mitsuba()
    vertices, normals, faces = _fan(elevation, view)
    # Sionna computes in another variant, so this one holds only while the picture is made.
    with mi.util.scoped_set_variant(backend.variant.replace("mono_polarized", "rgb")):
        scene = mi.load_dict(
            {
                "type": "scene",
                "sea": _water(mi, vertices, normals, faces, unresolved_mss),
                "sky": _sky(sky),
                "camera": _camera(mi, view),
                # Light may go from wave to wave: without, the far sides of the nearest crests are black.
                "integrator": {"type": "path", "max_depth": 1 + _BOUNCES},
            }
        )
        strata = math.isqrt(samples - 1) + 1  # the sampler's, along each side of a pixel
        radiance = np.array(mi.render(scene, spp=strata**2, seed=seed), dtype=np.float64)
    return _developed(radiance)


def _check(elevation: Elevation, view: View, sky: Sky, unresolved_mss: float, samples: int) -> None:
    foot = float(elevation(np.zeros(1), np.zeros(1))[0])
    if not foot < view.height_m < np.inf:
        raise ValueError(
            f"height_m = {view.height_m:g}: must be finite and above the water at the mast, {foot:.2f} m; raise it"
        )
    if min(view.size) < 1:
        raise ValueError(f"size = {view.size}: must be at least 1 column and 1 row; give (columns, rows)")
    if not 1.0 <= view.field_of_view_deg <= 120.0:
        raise ValueError(f"field_of_view_deg = {view.field_of_view_deg:g}: must be 1 to 120; 60 is a normal lens")
    if not -90.0 < view.tilt_deg <= view.lowest_deg <= _STEEPEST_DEG:
        raise ValueError(
            f"tilt_deg = {view.tilt_deg:g}: must leave the last line less than {_STEEPEST_DEG:g}° below level, "
            f"it looks {view.lowest_deg:.1f}° down; lower tilt_deg, field_of_view_deg or the number of rows"
        )
    if not 0.0 <= sky.sun_elevation_deg <= 90.0:
        raise ValueError(f"sun_elevation_deg = {sky.sun_elevation_deg:g}: must be 0 to 90; the sky is a day's")
    if not 1.0 <= sky.turbidity <= 10.0:
        raise ValueError(f"turbidity = {sky.turbidity:g}: must be 1 to 10, the sky model's range; 3 is a clear day")
    if not 0.0 < unresolved_mss <= 0.2:
        raise ValueError(f"unresolved_mss = {unresolved_mss:g}: must be above 0 and at most 0.2; 0.02 is usual")
    if samples < 1:
        raise ValueError(f"samples = {samples}: must be at least 1; 25 give a fair picture, 64 a clean one")


def _fan(elevation: Elevation, view: View) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.uint32]]:
    """Vertices (n, 3), upward unit normals (n, 3) and faces (m, 3) of the sea, finer than the picture where it counts.

    The normals are those of the mesh itself: far out, where it is coarser than the waves, their true slopes would
    tilt it away from the eye that sees it.
    """
    ranges = _ranges(view.height_m)
    half = view.widest_deg + _MARGIN_DEG
    lines = max(8, round(_LINES_PER_COLUMN * np.radians(2.0 * half) * view.focal_length))
    east, north = unit_from_azimuth(view.azimuth_deg + np.linspace(-half, half, lines))
    point = np.empty((ranges.size, lines, 3))
    point[..., 0], point[..., 1] = ranges[:, None] * east, ranges[:, None] * north
    fade = np.interp(ranges / view.height_m, [_WAVES_FADE_FROM, _WAVES_END], [1.0, 0.0])
    waves = fade > 0.0
    point[~waves, :, 2] = 0.0
    point[waves, :, 2] = fade[waves, None] * elevation(point[waves, :, 0], point[waves, :, 1])

    outward, clockwise = np.gradient(point, axis=0), np.gradient(point, axis=1)
    normal = np.cross(clockwise, outward)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)

    number = np.arange(ranges.size * lines, dtype=np.uint32).reshape(ranges.size, lines)
    near_left, near_right, far_left, far_right = (
        part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:])
    )
    faces = np.stack([near_left, near_right, far_left, near_right, far_right, far_left], axis=-1).reshape(-1, 3)
    return point.reshape(-1, 3), normal.reshape(-1, 3), faces


def _ranges(height: float) -> NDArray[np.float64]:
    """Ground ranges of the mesh's vertices: even near the mast, then growing with the range, then a flat plane."""
    ranges = [_NEAREST * height]
    while ranges[-1] < _WAVES_END * height:
        ranges.append(ranges[-1] + max(_RANGE_SPACING, _RANGE_GROWTH * ranges[-1]))
    while ranges[-1] < _HORIZON * height:
        ranges.append(2.0 * ranges[-1])
    return np.array(ranges)


def _water(
    mi: Any, vertices: NDArray[np.float64], normals: NDArray[np.float64], faces: NDArray[np.uint32], mss: float
) -> Any:
    mesh = mitsuba_mesh("sea", as_trimesh(vertices, faces), normals)
    mesh.set_bsdf(
        mi.load_dict(
            {
                "type": "roughplastic",  # a rough mirror over a coloured body, by Fresnel's shares
                "distribution": "beckmann",
                "alpha": math.sqrt(mss),
                "int_ior": _REFRACTIVE_INDEX,
                "diffuse_reflectance": {"type": "rgb", "value": list(_BODY)},
            }
        )
    )
    return mesh


def _sky(sky: Sky) -> dict[str, Any]:
    east, north = unit_from_azimuth(sky.sun_azimuth_deg)
    up, level = np.sin(np.radians(sky.sun_elevation_deg)), np.cos(np.radians(sky.sun_elevation_deg))
    return {
        "type": "sunsky",
        "sun_direction": [float(level * east), float(level * north), float(up)],
        "turbidity": sky.turbidity,
        "albedo": 0.05,  # of the sea
        "sun_scale": 0.0,
    }


def _camera(mi: Any, view: View) -> dict[str, Any]:
    east, north = unit_from_azimuth(view.azimuth_deg)
    aim = [float(east), float(north), view.height_m - math.tan(math.radians(view.tilt_deg))]
    # A ray counts for its own pixel only ("box"): shared ones would be summed in the threads' order, never the same.
    film = {"type": "hdrfilm", "width": view.size[0], "height": view.size[1], "pixel_format": "rgb"}
    return {
        "type": "perspective",
        "fov": view.field_of_view_deg,
        "fov_axis": "x",
        "to_world": mi.ScalarTransform4f().look_at(origin=[0.0, 0.0, view.height_m], target=aim, up=[0.0, 0.0, 1.0]),
        "near_clip": 0.1 * _NEAREST * view.height_m,
        "far_clip": 4.0 * _HORIZON * view.height_m,
        "film": {**film, "rfilter": {"type": "box"}},
        "sampler": {"type": "multijitter"},
    }


def _developed(radiance: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Radiance (rows, columns, 3) as an sRGB picture (IEC 61966-2-1), exposed by its mean like a camera's."""
    luminance = radiance @ np.array([0.2126, 0.7152, 0.0722])
    mean = np.exp(np.mean(np.log(np.maximum(luminance, 1e-6))))
    # A film's curve: highlights are compressed, none is clipped.
    linear = 1.0 - np.exp(-_EXPOSURE / mean * np.maximum(radiance, 0.0))
    coded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
    return np.round(255.0 * coded).astype(np.uint8)
