"""[sea]: the water, its wave systems, and how much of them the surface resolves."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BeforeValidator, model_validator

from .section import Direction, Meaning, Section, as_tuple, compass
from .waves import RandomWaves, WaveSystem

DEFAULT_RESOLUTION_M = 0.8
MOST_POINTS_A_SIDE = 4096


class SeaSettings(Section):
    """The water: its depth, its current, its wave systems, and the finest wave that is resolved.

    Any number of wave systems add up. Periods and spectra are those that one meets who drifts with the current. Waves
    follow the full dispersion relation, with depth and surface tension. Waves shorter than twice `resolution_m` are not
    on the surface but in the scattering; which waves are on the surface decides what hides behind crests.
    """

    model: Literal["linear", "choppy", "recorded"] = "linear"
    """`linear` waves, or `choppy`: first-order Lagrangian waves, whose crests are sharper; a scene of which more than 2
    % of the water folds over at time 0 is refused. `recorded`: the surface of `file`."""
    file: str = ""
    """Of a recorded sea: NetCDF or Zarr of the elevation over time, y and x (metres east and north of the antenna),
    HOS-ocean's `3d.dat`, a stereo camera's grids. Side, spacing, depth and spectrum are the file's where they are left
    out."""
    beyond: Literal["refused", "level", "mirrored"] = "refused"
    """Beyond a recorded patch that ends within the range circle: `refused`, or the sea goes on `level`, or `mirrored`
    at the patch's edges. Nothing there is judged: no metric, gauge or forecast takes a cell of it."""
    start_s: Annotated[
        float | None,
        Ge(-1e9),
        Le(1e9),
        Meaning(
            "s",
            "times of a record; it must hold the run",
            left_out="as early as the record allows: what is interpolated and heard before time 0 takes its beginning",
        ),
    ] = None
    """Time of a recorded sea's file, of dates from its first, that is the scene's time 0."""
    depth_m: Annotated[float, Ge(0.05), Meaning("m", "water has a depth; inf is deep", infinite=True)] = math.inf
    """Depth of the water; inf is deep."""
    resolution_m: Annotated[
        float | None,
        Gt(0.0),
        Le(100.0),
        Meaning(
            "m", "spacing of the resolved waves' grid", left_out=f"{DEFAULT_RESOLUTION_M}, or by `energy_fraction`"
        ),
    ] = None
    """Spacing of the grid of resolved waves: the shortest wave on the surface is twice as long."""
    energy_fraction: Annotated[
        float | None,
        Gt(0.0),
        Lt(1.0),
        Meaning("1", "share of the waves' variance that is resolved", left_out="by `resolution_m`"),
    ] = None
    """Share of the waves' variance that is to be on the surface: asks for the resolution that keeps it, in place of
    `resolution_m`."""
    extent_m: Annotated[float, Ge(10.0), Le(20_000.0), Meaning("m", "side of the periodic patch")] = 1024.0
    """Side of the periodic patch of sea; it must hold the range circle, unless the waves do not repeat (`sinusoid`,
    `flat`, `long_crested`)."""
    current_m_s: Annotated[float, Ge(0.0), Le(10.0), Meaning("m/s", "a uniform current")] = 0.0
    """Speed of a uniform current, which carries the waves."""
    current_toward_deg: Annotated[Direction, compass("Direction to which the current flows")] = 0.0
    waves: Annotated[tuple[WaveSystem, ...], BeforeValidator(as_tuple)] = ()
    """Wave systems, `[[sea.waves]]`: wind sea and swells, each with its own spectrum."""

    @model_validator(mode="before")
    @classmethod
    def _default_resolution(cls, tree: object) -> object:
        if isinstance(tree, dict) and tree.get("resolution_m") is None and tree.get("energy_fraction") is None:
            return {**tree, "resolution_m": DEFAULT_RESOLUTION_M}
        return tree

    @model_validator(mode="after")
    def _one_resolution(self) -> Self:
        if self.resolution_m is not None and self.energy_fraction is not None:
            raise ValueError("give resolution_m or energy_fraction, not both: one follows from the other")
        return self

    @model_validator(mode="after")
    def _recorded_somewhere(self) -> Self:
        if self.model == "recorded" and not self.file:
            raise ValueError("model = 'recorded': needs `file`, the recorded sea; name it")
        if self.model == "recorded" and not any(isinstance(waves, RandomWaves) for waves in self.waves):
            raise ValueError(
                "waves: must hold the spectrum of the recorded sea, from which the mesh is sized; leave `waves` out, "
                "and it is taken from the file"
            )
        if self.model != "recorded" and self.beyond != "refused":
            raise ValueError(
                f"beyond = '{self.beyond}': must be 'refused' where model = '{self.model}', which has no edge; "
                "leave it out"
            )
        if self.model != "recorded" and self.start_s is not None:
            raise ValueError(f"model = '{self.model}': has no record to begin in; leave start_s = {self.start_s:g} out")
        if self.model == "recorded" and self.current_m_s:
            raise ValueError(
                f"current_m_s = {self.current_m_s:g}: must be 0 where model = 'recorded' (the record holds what the "
                "current did to its waves); tell it to the retrieval, as retrieval.current_m_s"
            )
        return self

    @model_validator(mode="after")
    def _grid_fits_memory(self) -> Self:
        if self.resolution_m is not None:
            check_grid(self.extent_m, self.resolution_m)
        return self


def check_grid(extent_m: float, resolution_m: float, energy_fraction: float | None = None) -> None:
    """Raise ValueError unless the grid of resolved waves fits memory and holds waves.

    energy_fraction: the share from which the resolution follows, if it was not given itself.
    """
    side = extent_m / resolution_m
    cause = "" if energy_fraction is None else f"energy_fraction = {energy_fraction!r}: asks for {resolution_m:.3g} m, "
    key = "resolution_m" if energy_fraction is None else "energy_fraction"
    finer, coarser = ("lower", "raise") if energy_fraction is None else ("raise", "lower")
    if side > MOST_POINTS_A_SIDE:
        raise ValueError(
            f"{cause}extent_m/resolution_m = {side:.0f}: must be at most {MOST_POINTS_A_SIDE} (a grid of {side:.0f}² "
            f"points would take {side * side * 100 / 1e9:.3g} GB); {coarser} {key} or lower extent_m"
        )
    if side < 8:
        raise ValueError(f"{cause}extent_m/resolution_m = {side:.1f}: must be at least 8; {finer} {key}")
