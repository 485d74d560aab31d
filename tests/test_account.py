"""What a run says of itself: the account follows the scene's own keys."""

from __future__ import annotations

from typing import Any

import pytest

from seamap_rt.account import left_out, modelled
from seamap_rt.scene import load_scene
from seamap_rt.sea import realize


def account(**keys: Any) -> tuple[str, str]:
    """All that is said to be modelled, and to be left out, of a small scene with other keys."""
    small = {"sea.extent_m": 420.0, "sea.resolution_m": 2.0, "radar.range_m": [30.0, 150.0]}
    scene = load_scene("tiny", small | {key.replace("__", "."): value for key, value in keys.items()})
    resolved = realize(scene.sea, 1).resolved
    said = (modelled(scene, resolved), left_out(scene, resolved))
    return tuple("; ".join(f"{row['what']}: {row['why']}" for row in rows) for rows in said)  # type: ignore[return-value]


@pytest.mark.parametrize(
    ("keys", "done", "missing"),
    [
        ({}, "breakers, most of them where the resolved waves converge", "a breaker's life"),
        ({"scattering__breaking": False}, "strain of the resolved waves", "scattering.breaking = false"),
        ({"scattering__hydrodynamic_modulation": False}, "breakers", "tilt alone modulates"),
        ({"scattering__doppler": "orbital"}, "follows its water particle", "the scatterers' own velocity"),
        ({"scattering__calibrated_to": "none"}, "theory's own mean", "a breaker's life"),
        ({"scattering__calibrated_to": "tsc"}, "Technology Service Corporation 1990", "outside 0.1–90° grazing"),
        ({"scattering__nrcs": "hybrid"}, "the mean of Reilly & Dockery 1990", "tilt, strain and breakers"),
        ({"scattering__nrcs": "constant"}, "-40 dB per horizontal area", "tilt, strain and breakers"),
        ({}, "shadow ray", "tracing.diffraction = 'knife_edge'"),
        ({"tracing__diffraction": "knife_edge"}, "two knife edges", "what diffraction does to heights"),
        (
            {"scattering__extrapolate": True, "scattering__wind_speed_m_s": 20.0},
            "Gregers-Hansen",
            "this scene is sea state 10 at",
        ),
    ],
)
def test_the_account_follows_the_keys(keys: dict[str, Any], done: str, missing: str) -> None:
    was, was_not = account(**keys)
    assert done in was
    assert missing in was_not


def test_what_is_modelled_is_not_called_missing() -> None:
    _, default = account()
    for word in ("scattering.breaking = false", "own velocity", "tilt alone", "own range", "diffraction does"):
        assert word not in default
    _, diffracted = account(tracing__diffraction="knife_edge")
    assert "diffraction at shadow edges" not in diffracted
