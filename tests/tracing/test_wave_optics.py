"""The judge of shadows by wave optics: against Fresnel's coefficients, a wedge's exact field, the whole equation."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.special import hankel2

from validation.analytic.diffraction import knife_edge, wedge_faces
from validation.light.wave_optics import Profile, sine_of_grazing, surface_field

Array = NDArray[np.floating]
WAVE = 0.03
K = 2.0 * np.pi / WAVE
WATER = np.sqrt(54.0 - 37.5j) / (55.0 - 37.5j)


def level(start: float, stop: float) -> Profile:
    x = np.arange(start, stop, 0.006)
    return Profile(x, *np.zeros((3, x.size)))


def test_level_water_is_lit_by_fresnel_s_coefficients() -> None:
    """½ (1 + Γ) = s/(s + α) to 1 %: the ground wave beside it is 1/(2kR (s + α)²) of it, 0.4 % at 20 m."""
    profile, source = level(10.0, 70.0), (0.0, 5.0)
    field, sine = surface_field(profile, source, WAVE, complex(WATER)), sine_of_grazing(profile, source)
    far = profile.x > 20.0
    assert_allclose(field.vv[far], (sine / (sine + WATER))[far], rtol=0.01)
    assert_allclose(field.vv_conductor, 1.0, atol=1e-12)
    assert_allclose(field.hh, sine, rtol=3e-4)  # 1/(2kR): the source is not at infinity


@pytest.mark.parametrize(("rise", "fall"), [(0.1, 0.15), (0.05, 0.2)])
def test_a_wedge_s_shadow_holds_what_its_exact_field_does(rise: float, fall: float) -> None:
    """To 1.5 % of the field, down to 0.1 (VV) and 0.0005 (HH) of it; on the lit face what the edge scatters back, at
    most 1 %, is missing."""
    edge, source = 20.0, (0.0, 3.0 - 20.0 * rise)
    x = 1.5025 + 0.005 * np.arange(5600)  # the edge lies between points
    before = x < edge
    profile = Profile(
        x, np.where(before, x - edge, edge - x) * np.where(before, rise, fall), np.where(before, rise, -fall), 0.0 * x
    )
    field = surface_field(profile, source, WAVE, 0.0)
    far, angle = float(np.hypot(edge, source[1])), float(np.arctan(rise) + np.arctan2(source[1], edge))
    exterior = float(np.pi + np.arctan(rise) + np.arctan(fall))
    for place in (15.0, 19.0, 20.1, 20.5, 21.0, 25.0, 29.0):
        point = int(np.searchsorted(x, place))
        away = abs(x[point] - edge) * float(np.hypot(1.0, profile.slope[point]))
        vv, hh = (each[int(place > edge)] for each in wedge_faces(away, far, angle, exterior, WAVE))
        assert abs(field.vv_conductor[point] / (0.5 * vv) - 1.0) < 0.015, place
        assert abs(field.hh[point] / (0.5 * hh / 1j) - 1.0) < 0.015, place


def test_a_wedge_seen_along_its_face_casts_a_knife_edge_s_shadow() -> None:
    """The exact series itself: a source on the lit face's own plane, where direct and mirrored rays are one, and a
    shadow of 0.1 rad: both faces double what passes the edge, 4F. 2 %: the knife edge is paraxial."""
    fall, far = 0.1, 60.0
    for away in (0.5, 2.0, 6.0):
        vv, _ = wedge_faces(away, far, 0.0, np.pi + fall, WAVE)
        v = fall * np.sqrt(2.0 * far * away / (WAVE * (far + away)))
        assert abs(vv[1]) == pytest.approx(4.0 * abs(knife_edge(v)), rel=0.02)


def rough(seed: int) -> tuple[Profile, tuple[float, float]]:
    """7 m of a sea of waves from 4 m down to 0.13 m, S ∝ k⁻³, seen from 1.5 m before and 0.6 m above it."""
    random = np.random.default_rng(seed)
    x = 1.5 + 0.0075 * np.arange(930)
    k = np.arange(1.5, 50.0, 0.25)
    wave = np.sqrt(0.01 * k**-3.0 * 0.25) * (random.standard_normal((2, k.size)).T @ [1.0, 1.0j])
    height, slope, bend = (np.real(np.exp(1j * np.outer(x, k)) @ (wave * (1j * k) ** n)) for n in range(3))
    return Profile(x, height, slope, bend), (0.0, 0.6)


def whole(profile: Profile, source: tuple[float, float]) -> tuple[Array, Array]:
    """|∂ₙψ|/2k and |ψ|/2 over |ψᵢ| on a conductor, of the integral equations in both directions, fading out too."""
    x, z, slope = profile.x, profile.height, profile.slope
    stretch = np.hypot(1.0, slope)
    fades = np.sin(0.5 * np.pi * np.clip(np.minimum((x - x[0]) / 3.0, x[-1] - x), 0.0, 1.0)) ** 2
    dx, dz = x[:, None] - x, z[:, None] - z
    r = np.hypot(dx, dz)
    np.fill_diagonal(r, 1.0)
    kernel = 0.25j * K * hankel2(1, K * r) / r * profile.step * fades
    itself = profile.bend / (4.0 * np.pi * stretch**2) * profile.step
    e = kernel * (dz - slope[:, None] * dx) / stretch[:, None] * stretch
    h = kernel * (dz - slope * dx)
    np.fill_diagonal(e, itself)
    np.fill_diagonal(h, -itself)
    reach = np.hypot(x - source[0], z - source[1])
    free = np.exp(-1j * K * reach) / np.sqrt(reach)
    incident = 1j * K * sine_of_grazing(profile, source) * (1.0 - 0.5j / (K * reach)) * free
    half = 0.5 * np.eye(x.size)
    return np.abs(np.linalg.solve(half + e, incident) / (2.0 * K * free)), np.abs(
        np.linalg.solve(half + h, free) / (2.0 * free)
    )


def test_a_march_is_the_whole_equation_but_for_what_is_scattered_back() -> None:
    """To 0.5 % rms on a sea with shadows: waves that are longer than two of the radar's send next to nothing back."""
    profile, source = rough(4)
    field = surface_field(profile, source, WAVE, 0.0)
    inner = (profile.x > 4.5) & (profile.x < 7.0)
    for march, exact in zip((field.hh, field.vv_conductor), whole(profile, source), strict=True):
        off = (np.abs(march) - exact)[inner]
        assert np.sqrt(np.mean(off**2) / np.mean(exact[inner] ** 2)) < 0.005
        assert exact[inner].min() < 0.3 * exact[inner].max()  # there are shadows


def test_a_source_behind_or_coarse_steps_are_refused() -> None:
    with pytest.raises(ValueError, match="before the profile"):
        surface_field(level(10.0, 12.0), (11.0, 5.0), WAVE, 0.0)
    with pytest.raises(ValueError, match="quarter of a wave"):
        surface_field(level(10.0, 12.0), (0.0, 5.0), 0.02, 0.0)
