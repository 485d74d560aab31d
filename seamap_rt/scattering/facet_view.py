"""How a ray meets a tilted plane: its incidence, the turn of its polarization, and the wind in the plane's own axes.

Facets of the mesh and the unresolved tilts on them are both such planes, one upon the other.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]


class FacetView(NamedTuple):
    """Arrays of one shape; θi is the incidence against the plane's own normal, χ the turn of the Bragg vector."""

    cos_local: Array  # cos θi, negative from behind
    inverse_sine2: Array  # 1/sin² θi; 0 for a plane seen squarely
    along_range: Array  # the ray's projection on the plane, of length sin θi: down the plane's own range axis …
    along_cross: Array  # … and anticlockwise
    a2: Array  # A², the share of the polarization that stays: A = sin(θ − s_in) cos s_cross/sin θi
    ab: Array  # A B, B = sin s_cross/sin θi, A² + B² = 1

    def wind_double(self, along: Array, across: Array) -> tuple[Array, Array]:
        """cos and sin of 2 (w − χ), from cos w and sin w: the wind's axis against the Bragg vector."""
        square = self.inverse_sine2 == 0.0
        cosine = np.where(square, 1.0, (self.along_range**2 - self.along_cross**2) * self.inverse_sine2)
        sine = 2.0 * self.along_range * self.along_cross * self.inverse_sine2
        wind_cosine, wind_sine = along * along - across * across, 2.0 * along * across
        return wind_cosine * cosine + wind_sine * sine, wind_sine * cosine - wind_cosine * sine

    def upwind(self, along: Array, across: Array) -> Array:
        """sin θi cos(w − χ): what a tilt towards the wind's origin adds to cos θi, per slope and with its sign."""
        return along * self.along_range + across * self.along_cross


def facet_view(sine: Array, cosine: Array, slope_range: Array, slope_cross: Array) -> FacetView:
    """The view along a ray with sin θ and cos θ against the vertical, for slopes outward and clockwise; they broadcast.

    With s_in and s_cross the tilts, cos θi = cos(θ − s_in) cos s_cross; the Bragg vector is the ray's projection on the
    plane, of length sin θi, and turns anticlockwise from the look by χ, tan χ = cos(θ − s_in) sin s_cross/sin(θ − s_in)
    (Valenzuela, Boundary-Layer Meteorol. 13, 61–85, 1978). A plane seen squarely counts as A = 1, χ = 0.
    """
    p, q = slope_range, slope_cross
    in_plane = 1.0 / (1.0 + p * p)  # cos² s_in
    normal_up = 1.0 / (1.0 + p * p + q * q)  # (cos s_in cos s_cross)²
    towards, away = cosine + p * sine, sine - p * cosine  # cos(θ − s_in), sin(θ − s_in), both over cos s_in
    up = np.sqrt(normal_up)
    root = np.sqrt(in_plane)
    along_range, along_cross = away * root, towards * root * (q * up)
    sine2 = along_range * along_range + along_cross * along_cross
    square = sine2 < 1e-12
    inverse = np.where(square, 0.0, 1.0 / np.where(square, 1.0, sine2))
    b = q * normal_up * inverse
    return FacetView(
        cos_local=np.minimum(towards * up, 1.0),
        inverse_sine2=inverse,
        along_range=along_range,
        along_cross=along_cross,
        a2=1.0 - np.minimum(q * b, 1.0),
        ab=away * b,
    )
