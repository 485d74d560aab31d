"""Units as files spell them: what each is in another, by tables that are written down twice; and what is none."""

from __future__ import annotations

import time
from itertools import product

import numpy as np
import pytest

from seamap_rt.errors import InputError
from seamap_rt.io.declared import conversion_factor, to_unit
from validation.fuzz import declarations as fuzz

TABLES = {
    "m": fuzz.LENGTHS, "s": fuzz.TIMES, "degree": fuzz.ANGLES, "Hz": fuzz.HERTZ, "rad/s": fuzz.RATES,
    "m2/Hz/degree": {
        angle.format(hertz.format(area)): one * two * three
        for (area, one), (hertz, two), (angle, three) in product(
            fuzz.AREAS.items(), fuzz.PER_HERTZ.items(), fuzz.PER_ANGLE.items())
        if "J" not in area
    },
}  # fmt: skip
NONE = (*fuzz.NO_UNITS, "", " ", "nm", "degrees_north", "mhz", "m 2", "m//s", "(m", "m)", "/m", "1e400 m", "m^99999",
        "m" * 90, "(" * 79, "m_2", "m\n", "ｍ２", "degree ???", "10")  # fmt: skip


@pytest.mark.parametrize("unit", TABLES)
def test_every_spelling_has_its_size(unit: str) -> None:
    for spelling, size in TABLES[unit].items():
        assert conversion_factor(spelling, unit) == pytest.approx(size, rel=1e-12), spelling


@pytest.mark.parametrize("unit", TABLES)
def test_what_is_of_another_kind_has_none(unit: str) -> None:
    """Of two kinds nothing is the other, but frequencies and rates of turning, which 2π parts."""
    for kind, table in TABLES.items():
        for spelling in table if {kind, unit} != {"Hz", "rad/s"} and kind != unit else ():
            assert conversion_factor(spelling, unit) is None, spelling
    for spelling in (each for each in NONE if each not in TABLES[unit] and each.strip() not in TABLES[unit]):
        assert conversion_factor(spelling, unit) is None, spelling


def test_hostile_words_are_answered_at_once() -> None:
    begun = time.process_time()
    for text in ("(" * 10_000, "m " * 40, "9" * 80 + " m", "m^9 " * 20, "/".join("m" * 40), "e" * 79, " " * 79):
        assert conversion_factor(text, "m") is None, text
    assert time.process_time() - begun < 0.5


def test_numbers_without_a_unit_stay_the_same_array() -> None:
    values = np.arange(3, dtype=np.float32)
    for declared in (None, "", " ", "m", "metres"):
        assert to_unit(values, declared, "m", "x") is values
    with pytest.raises(InputError, match=r"range: is in 'kg': must be in m"):
        to_unit(values, "kg", "m", "range")
