"""Claims and measured cases: what they reckon with obeys its laws, and an error planted in it turns a case red."""

from __future__ import annotations

import importlib
from types import ModuleType

import numpy as np
import pytest
from numpy.testing import assert_allclose

from seamap_rt.radar import link
from validation.report import Case
from validation.report.discovery import cases_folder, load_cases

MODULES = ("claims", "measured", "stability", "costs")


@pytest.fixture(scope="module")
def cases() -> dict[str, Case]:
    return {case.name: case for case in load_cases(cases_folder())}


@pytest.fixture(scope="module")
def sampling(cases: dict[str, Case]) -> ModuleType:
    return importlib.import_module("validation.claims.sampling")


def red(cases: dict[str, Case], name: str) -> list[str]:
    return [check.what for check in cases[name].run(False).checks if check.passed is False]


def test_all_nine_claims_are_judged_in_order(cases: dict[str, Case]) -> None:
    titles = [case.title for case in cases.values() if case.group == "claims of 2004"]
    assert [title.split(".")[0] for title in titles] == [str(number) for number in range(1, 10)]


@pytest.mark.parametrize(
    ("name", "verdict"),
    [
        ("claim_1_range_resolution", "reproduced"),
        ("claim_2_beam", "only if"),
        ("claim_3_weakest_sea", "only if"),
        ("claim_5_data_rate", "only if"),
    ],
)
def test_the_radar_s_claims(cases: dict[str, Case], name: str, verdict: str) -> None:
    found = cases[name].run(False)
    assert found.verdict == verdict
    assert all(check.passed is not False for check in found.checks)
    assert bool(found.assumption) == (verdict == "only if")


def test_a_wider_footprint_turns_its_claim_red(cases: dict[str, Case], monkeypatch: pytest.MonkeyPatch) -> None:
    footprint = link.footprint_m
    monkeypatch.setattr(link, "footprint_m", lambda *given: 1.1 * footprint(*given))
    across = ["across the beam at 100 m", "across the beam at 200 m"]
    assert red(cases, "claim_2_beam") == [*across, "verdict of claim 2b"]


def test_energy_runs_at_the_group_speed(cases: dict[str, Case]) -> None:
    run_in = importlib.import_module("validation.claims.maps").run_in
    # g T/4π in deep water; surface tension speeds waves of 4 s up by less than 1e-5.
    for period in (4.0, 6.0, 8.0, 10.0):
        assert run_in(period) == pytest.approx(10.0 * 9.81 * period / (4.0 * np.pi), rel=1e-3)


def test_gain_and_coherence_of_known_maps(sampling: ModuleType) -> None:
    random = np.random.default_rng(1)
    sea = random.standard_normal((200, 60))
    for share in (0.0, 1.0):
        mapped = 0.5 * sea + share * random.standard_normal(sea.shape)
        own, cross, product = sampling.spectra((mapped, sea, 1.5))
        assert_allclose(cross / own, 0.5, atol=0.1)  # 200 lines of a few independent wavenumbers a band: 0.04
        expected = 0.25 / (0.25 + share**2)
        assert_allclose(cross**2 / (own * product), expected, atol=0.1)


def test_the_shortest_wave_that_a_map_holds(sampling: ModuleType) -> None:
    middles = sampling.MIDDLES_M
    coherence = np.where(np.arange(middles.size) < 3, 0.25, 0.75)
    found = sampling.Transfer(np.ones(middles.size), coherence).shortest()
    assert found == pytest.approx(0.5 * (middles[2] + middles[3]))
    assert sampling.Transfer(coherence, np.zeros(middles.size)).shortest() == np.inf
    assert sampling.Transfer(coherence, np.ones(middles.size)).shortest() == sampling.BANDS_M[0]


@pytest.mark.parametrize("name", ["hard_far_phases", "hard_one_facet", "hard_along_the_ray", "hard_crest"])
def test_quick_hard_cases_are_right(cases: dict[str, Case], name: str) -> None:
    assert red(cases, name) == []


def test_a_hard_case_that_goes_wrong_is_red(cases: dict[str, Case], monkeypatch: pytest.MonkeyPatch) -> None:
    light = importlib.import_module("validation.hard_cases.light")
    lit = light.light
    monkeypatch.setattr(light, "light", lambda *given: ~lit(*given))
    assert red(cases, "hard_one_facet") == ["one column of two facets"]


def test_cases_say_why_and_how(cases: dict[str, Case]) -> None:
    assert len(cases) == len(set(cases))
    for case in cases.values():
        assert case.name.isidentifier()
        for words in (case.title, case.rationale, case.setup, case.expectation):
            assert words.strip()


def test_no_module_fails_to_load(cases: dict[str, Case]) -> None:
    for module in MODULES:
        mine = importlib.import_module(f"validation.cases.{module}").CASES
        assert {case.name for case in mine} <= set(cases)
