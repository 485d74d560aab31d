"""How dark the shadows of small waves are to a radar: wave optics on profiles that carry all waves, and on the same
without the small ones.

    python -m validation.light.wave_shadows [--profiles 4] [--seed 7] [--only SEA]

Profiles as `unresolved_profiles` draws them, from 10 to 205 m, at steps of 6 mm and a wavelength of 3 cm, with the
fields of `wave_optics`. Judged are 25–200 m, by what rays say: places that all waves leave in sight, that small ones
alone hide (behind them or on their backs), and that the resolved hide. Printed for each sea:

- of the places that only small waves hide, the share of the window; and the power that they keep, |field|² one way and
  |field|⁴ there and back, over that without the small waves, in HH, VV and VV over a conductor, beside `shadow_kept`;
- what such places hold of the echo: by wave optics, and by tilted facets that cast no shadow;
- by how much, dB rms over bins of the facets' own grazing angle, equal areas alike, the echo of lit facets is off after
  one common factor (the calibration): without shadows, with those that waves leave, and with light's.

Tilted facets answer as their own slope says, ½ |1 + Γ| of it to the fourth, or its sine (HH). Twenty seconds of
processor time a sea.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seamap_rt.physics.shadowing import facing_share_smith67, shadow_kept
from seamap_rt.scattering.permittivity import permittivity_meissner_wentz12

from .unresolved_profiles import CASES, POINTS, STEP_M, Array, Case, both, drawn, visible, wavenumbers
from .wave_optics import Profile, sine_of_grazing, surface_field

FINE, NEAR_M, FAR_M, BEGIN_M, END_M = 75_000, 25.0, 200.0, 10.0, 205.0
WAVELENGTH_M = 0.03
GRAZING = np.array([0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0, 20.0])  # over the rms slope
FEWEST = 300  # points of a bin
POLARIZATIONS = "hh", "vv", "vv_conductor"


@dataclass(frozen=True)
class Lit:
    """(point,) of a profile: in sight to rays, sine of the grazing angle, |field| by polarization."""

    seen: NDArray[np.bool_]
    sine: Array
    field: dict[str, Array]


@dataclass(frozen=True)
class Sea:
    """(profile, point) without and with the small waves, in the window, and those waves' rms height [m] and slope."""

    plain: Lit
    whole: Lit
    height: float
    slope: float

    @property
    def hidden(self) -> NDArray[np.bool_]:
        """By small waves alone."""
        return self.plain.seen & ~self.whole.seen


def water() -> complex:
    """Impedance of sea water at 10 GHz, 20 °C and 35 psu over that of free space, along the surface."""
    permittivity = complex(permittivity_meissner_wentz12(10e9, 20.0, 35.0))
    return complex(np.sqrt(permittivity - 1.0) / permittivity)


def lit(x: Array, surface: list[Array], mast: float) -> Lit:
    part = (x >= BEGIN_M) & (x < END_M)
    inner = (x[part] >= NEAR_M) & (x[part] < FAR_M)
    profile, source = Profile(x[part], *(each[part] for each in surface)), (0.0, mast)
    field = surface_field(profile, source, WAVELENGTH_M, water())
    size = {name: np.abs(getattr(field, name))[inner] for name in POLARIZATIONS}
    return Lit(visible(x, surface[0], mast)[part][inner], sine_of_grazing(profile, source)[inner], size)


def sea(case: Case, profiles: int, seed: int) -> Sea:
    look = wavenumbers()
    long, short = both(case, look)
    x, random = STEP_M * POINTS / FINE * np.arange(FINE), np.random.default_rng(seed)
    plain, whole = [], []
    for _ in range(profiles):
        resolved, small = (drawn(random, each, FINE, 2) for each in (long, short))
        plain.append(lit(x, resolved, case.mast))
        whole.append(lit(x, [a + b for a, b in zip(resolved, small, strict=True)], case.mast))
    slope, height = float(np.sqrt(short @ look**2)), float(np.sqrt(short.sum()))
    return Sea(together(plain), together(whole), height, slope)


def together(parts: list[Lit]) -> Lit:
    fields = {name: np.stack([each.field[name] for each in parts]) for name in POLARIZATIONS}
    return Lit(np.stack([each.seen for each in parts]), np.stack([each.sine for each in parts]), fields)


def kept(made: Sea, polarization: str, power: int) -> float:
    """Mean |field|^power of the places that small waves alone hide, over that without small waves."""
    with_them, without = (each.field[polarization][made.hidden] for each in (made.whole, made.plain))
    return float(np.mean(with_them**power) / np.mean(without**power))


def tilted(made: Sea, polarization: str) -> Array:
    """(profile, point) two-way power by the surface's own slope, without shadows."""
    sine = np.maximum(made.whole.sine, 0.0)
    return sine**4 if polarization == "hh" else np.abs(sine / (sine + water())) ** 4


def of_echo(made: Sea, polarization: str) -> tuple[float, float]:
    """Share of the two-way power that places hold which small waves alone hide: by wave optics, by tilted facets."""
    waves, facets = made.whole.field[polarization] ** 4, tilted(made, polarization)
    return float(waves[made.hidden].sum() / waves.sum()), float(
        facets[made.hidden].sum() / facets[made.plain.seen].sum()
    )


def off_db(made: Sea, polarization: str, kept_share: float) -> float:
    """Rms error of the lit facets' echo by their grazing angle, where small waves' shadows keep that share."""
    seen = made.plain.seen
    grazing = np.maximum(made.plain.sine[seen] / made.slope, 1e-3)
    facing = facing_share_smith67(grazing / np.sqrt(2.0))
    model = tilted(made, polarization)[seen] * (facing + kept_share * (1.0 - facing))
    place = np.digitize(grazing, GRAZING) - 1
    count, waves, facets = (
        np.bincount(place, each, GRAZING.size)
        for each in (np.ones(place.size), made.whole.field[polarization][seen] ** 4, model)
    )
    held = count > FEWEST
    off = 10.0 * np.log10(waves[held] / facets[held] * facets[held].sum() / waves[held].sum())
    return float(np.sqrt(np.average(off**2, weights=count[held])))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--profiles", type=int, default=4)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--only", choices=list(CASES))
    arguments = parser.parse_args()
    print(
        f"{'power over that without small waves':54}{'HH 1, 2 ways':>14}{'VV':>14}{'conductor':>14}{'law VV, HH2':>20}"
    )
    for name in [arguments.only] if arguments.only else CASES:
        made = sea(CASES[name], arguments.profiles, arguments.seed)
        two_way = {each: shadow_kept(made.height, made.slope, WAVELENGTH_M, each) for each in ("VV", "HH")}
        print(f"{name:26}{100 * made.hidden.mean():6.1f} % hidden, {1000 * made.height:4.1f} mm", end=5 * " ")
        print("".join(f"{kept(made, each, 2):8.2f}{kept(made, each, 4):6.2f}" for each in POLARIZATIONS), end=6 * " ")
        print(f"{np.sqrt(two_way['VV']):6.2f}{two_way['VV']:6.2f}{two_way['HH']:6.2f}")
        for each in ("vv", "hh"):
            waves, facets = of_echo(made, each)
            off = [off_db(made, each, share) for share in (1.0, two_way[each.upper()], 0.0)]
            print(f"    {each.upper()}: of the echo {100 * waves:.1f} %, by facets {100 * facets:.1f} %; off", end=" ")
            print("no shadows {:.2f}, waves' {:.2f}, light's {:.2f} dB".format(*off), flush=True)


if __name__ == "__main__":
    main()
