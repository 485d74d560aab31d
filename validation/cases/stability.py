"""Hard cases, at full size: rays along edges and facets, far ranges, after hours, scenes at the limits of settings.

`validation/hard_cases/` computes them, and its `report.py` runs them alone; here they are validation cases.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from seamap_rt.report import style

from ..hard_cases import extreme as hard_cases_extreme
from ..hard_cases import far as hard_cases_far
from ..hard_cases import light as hard_cases_light
from ..hard_cases import nonlinear as hard_cases_nonlinear
from ..hard_cases.case import Effort, Finding
from ..report import Case, Check, Group, Outcome

RAYS = {False: 1_000_000, True: 10_000_000}  # by full
Hard = Callable[[Effort], list[Finding]]


def outcome(hard: Hard, full: bool) -> Outcome:
    rows = style.styled(hard)(Effort(RAYS[full], full))
    checks = tuple(Check(row.case, row.obtained, row.expectation, row.right) for row in rows)
    drawn = [row for row in rows if row.figure is not None]
    return Outcome(checks, drawn[0].figure, f"{drawn[0].case}: {drawn[0].expectation}") if drawn else Outcome(checks)


def case_of(name: str, hard: Hard, group: Group, title: str, rationale: str, expectation: str) -> Case:
    setup = (hard.__doc__ or "").strip().splitlines()[0]
    return Case(name, group, title, rationale, setup, expectation, partial(outcome, hard))


CASES: list[Case] = [
    case_of(
        "hard_terminator",
        hard_cases_light.terminator,
        "light and shadow",
        "Terminators of a sinusoid at 0.1–1°",
        "At grazing rays an error of millimetres in height moves the edge of a shadow by metres.",
        "Every edge of light of the exact sinusoid to one facet, 0.5 m: between two facets an edge cannot be placed.",
    ),
    case_of(
        "hard_rays_against_horizon",
        hard_cases_light.rays_against_horizon,
        "light and shadow",
        "Rays against the horizon on a fine mesh",
        "float32 rays through a tree, and a running maximum in float64, have no line of code in common.",
        "Less than 0.02 % of facets differ, beside edges of shadow, where float32's rounding decides.",
    ),
    case_of(
        "hard_watertight",
        hard_cases_light.watertight,
        "light and shadow",
        "No ray slips between triangles",
        "A sea mesh is full of edges that rays run along; a leak lights what is dark.",
        "None at edges; aimed at facets at most 1 in 10⁵, which pass an edge within float32's rounding.",
    ),
    case_of(
        "hard_along_the_ray",
        hard_cases_light.along_the_ray,
        "light and shadow",
        "Facets that the ray runs along",
        "A facet edge-on is lit or dark by its last bit; what lies about it must not depend on that.",
        "No facet before or behind is dark; the slope itself by the sign of its tip from float32's rounding on.",
    ),
    case_of(
        "hard_slivers",
        hard_cases_light.slivers,
        "light and shadow",
        "Degenerate triangles at the mast's foot",
        "Columns of a polar mesh are millimetres wide there.",
        "A flat sea shadows nothing: exactly none of the facets in front of an antenna is dark.",
    ),
    case_of(
        "hard_one_facet",
        hard_cases_light.one_facet,
        "numerical stability",
        "The smallest mesh",
        "What counts facets, columns and rungs must survive two of them.",
        "Lit from the front, dark from behind, exactly.",
    ),
    case_of(
        "hard_far_from_origin",
        hard_cases_far.far_from_origin,
        "numerical stability",
        "10 km from the origin",
        "A boat goes on; float32 coordinates lose a millimetre in 10 km.",
        "The water is periodic, so all is as at the origin: voltages to 1e-4 of their rms, heights to 10 µm.",
    ),
    case_of(
        "hard_half_a_day",
        hard_cases_far.half_a_day,
        "numerical stability",
        "After twelve hours",
        "Phases ωt grow to 10⁵ rad, and turns are counted on.",
        "The sea is the sum of its waves as closely as at time 0, to twice its error there.",
    ),
    case_of(
        "hard_baselines",
        hard_cases_far.baselines,
        "numerical stability",
        "Baselines from 1 mm to 3 m",
        "A height is a difference of two ranges of which eight digits are alike.",
        "A flat sea of closed form is level to 1e-7 rad of phase, the rounding of complex64 voltages.",
    ),
    case_of(
        "hard_far_phases",
        hard_cases_far.far_phases,
        "numerical stability",
        "Phases out to 20 km",
        "At 20 km a phase has turned 10⁶ times.",
        "Within 1e-3 rad of extended precision: 1 % of the phase noise of a strong echo.",
    ),
    case_of(
        "hard_crest",
        hard_cases_extreme.crest,
        "numerical stability",
        "Antennas just above a crest, and in it",
        "Everything may be dark, or the antenna under water.",
        "Silence without a single invented height; under water refused in one line.",
    ),
    case_of(
        "hard_storm",
        hard_cases_extreme.storm,
        "numerical stability",
        "Seas that come over the antenna",
        "Pulses are lost in the middle of a turn.",
        "Lost pulses are NaN and flagged, all else is finite, and no cell is without a height or a reason.",
    ),
    case_of(
        "hard_nonlinear_seas",
        hard_cases_nonlinear.nonlinear_seas,
        "numerical stability",
        "Steep seas that go on",
        "A nonlinear sea that is too steep for its waves, or in shallow water, may blow up after minutes.",
        "It lives, loses to breaking alone, to 0.3 % of its energy, and from its middle goes on with the same bits.",
    ),
    case_of(
        "hard_choppy_wall",
        hard_cases_extreme.choppy_wall,
        "numerical stability",
        "Walls of water",
        "Choppy waves that nearly fold, and steps within one facet, are as steep as a mesh gets.",
        "Rays and horizon differ on less than 0.02 % of facets; behind a step it is dark to where the ray lands.",
    ),
    case_of(
        "hard_level",
        hard_cases_extreme.level,
        "numerical stability",
        "A sea of a micrometre",
        "Next to nothing must not be taken for nothing, nor divided by.",
        "Nothing in shadow, no NaN, heights of a flat sea with the same speckle to 1 µm, the waves' own height.",
    ),
    case_of(
        "hard_ten_million",
        hard_cases_extreme.ten_million,
        "numerical stability",
        "Meshes as large as memory",
        "What does not fit must be refused before it is begun.",
        "One line with the memory needed; with --full 10⁷ facets are traced, both ways alike to 0.02 %.",
    ),
]
