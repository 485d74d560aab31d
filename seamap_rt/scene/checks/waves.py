"""Seas that would break before they were so steep."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ...conventions import GRAVITY
from ...errors import refuse
from ...settings import PlatformSettings, SeaSettings

STEEPEST = 0.142  # significant wave height over the peak's wavelength: of the steepest regular wave (Michell 1893)


def check_record(sea: SeaSettings, platform: PlatformSettings) -> None:
    """A boat follows waves that are known one by one."""
    if sea.model == "recorded" and platform.motion == "wave_following":
        raise ValueError(
            "platform.motion = 'wave_following': must be fixed, sinusoidal or file where sea.model = 'recorded' (the "
            "boat follows waves that are known one by one); choose one of them"
        )


def check_steepness(sea: SeaSettings) -> None:
    """A system given by its height and period is not steeper than water stands. By the wavelength in deep water, of
    which that in shallow water falls short."""
    refuse(_too_steep(sea))


def _too_steep(sea: SeaSettings) -> Iterator[str]:
    for number, waves in enumerate(sea.waves):
        height, period = (getattr(waves, name, None) for name in ("significant_wave_height_m", "peak_period_s"))
        if height is None or period is None:
            continue
        length = GRAVITY * period**2 / (2.0 * math.pi)
        if height > STEEPEST * length:
            yield (
                f"sea.waves.{number}.significant_wave_height_m = {height:g}: must be at most {STEEPEST * length:.3g} "
                f"where peak_period_s = {period:g}, {STEEPEST:g} of the wavelength (steeper waves break; measured "
                "seas keep below 1/15, DNV-RP-C205); lower the height or lengthen the period"
            )
