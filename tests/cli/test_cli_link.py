"""`seamap-rt link`: what it prints and writes, whose numbers those are, and what it refuses."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from matplotlib.image import imread
from numpy.testing import assert_allclose

from seamap_rt.cli import main
from seamap_rt.conventions import db
from seamap_rt.products import link
from seamap_rt.products.link import PRODUCTS, link_budget, mean_sea, ranges_of, simulated_power, write_link
from seamap_rt.products.link_figure import draw
from seamap_rt.radar.link import flat_sea_power
from seamap_rt.radar.receiver import noise_power
from seamap_rt.radar.waveform import unambiguous_range_m
from seamap_rt.scattering import nrcs_gregers_hansen12, sea_state_from_wind
from seamap_rt.scene import Scene, load_scene
from seamap_rt.settings import RadarSettings
from validation.claims.weakest_sea import claim_minimum_nrcs

RANGES = np.array([50.0, 100.0, 200.0])


class Answer(NamedTuple):
    code: int
    out: str
    err: str


@pytest.fixture
def call(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Any:
    """`seamap-rt link` in this process, in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments: str) -> Answer:
        with pytest.raises(SystemExit) as end:
            main(["link", *arguments])
        said = capsys.readouterr()
        assert isinstance(end.value.code, int)
        return Answer(end.value.code, said.out, said.err)

    return run


def scene_of(**keys: Any) -> Scene:
    return load_scene("choppy_sea", overrides={key.replace("__", "."): value for key, value in keys.items()})


# --------------------------------------------------------------------------------------------- the command


def test_prints_facts_and_tables(call: Any) -> None:
    answer = call("choppy_sea", "--ranges", "50,100,200")
    assert (answer.code, answer.err) == (0, "")
    for words in (
        "-93.99 dBm in 50 MHz",
        "3.14 m at 100 m, 6.28 m at 200 m",
        "50 pulses a receiver",
        "non-coherent √N 8.49 dB",
        "blind to 3.00 m, unambiguous to 14990 m",
        "Gregers-Hansen & Mittal 2012",
    ):
        assert words in answer.out
    assert not list(Path().iterdir())
    lines = answer.out.splitlines()
    assert len([line for line in lines if line.split()[:1] == ["100.0"]]) == 3  # the sea, and a row in each budget
    assert max(map(len, lines)) <= 120
    row = next(line for line in lines if line.startswith("100.0")).split()
    assert row[1] == "2.87"  # asin(5/100) in degrees
    assert row[4] == "9.43"


def test_files_hold_what_is_printed(call: Any) -> None:
    answer = call("choppy_sea", "--ranges", "50,100,200", "--out", "results")
    assert answer.code == 0
    assert answer.out.splitlines()[-1] == "results/link.csv, results/link.png"
    assert sorted(path.name for path in Path("results").iterdir()) == sorted(PRODUCTS)
    with open("results/link.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    budget = link_budget(load_scene("choppy_sea"), RANGES)
    textbook, simulator = budget.budgets
    for name, values in (
        ("range_m", RANGES),
        ("nrcs_db", db(budget.nrcs)),
        ("cell_area_m2", budget.area),
        ("noise_dbm", np.full(3, db(1e3 * budget.noise))),
        ("textbook_echo_dbm", db(1e3 * textbook.power)),
        ("textbook_snr_noncoherent_db", db(textbook.snr[1])),
        ("simulator_snr_one_pulse_db", db(simulator.snr[0])),
        ("simulator_minimum_nrcs_coherent_db", db(simulator.minimum_nrcs[2])),
    ):
        assert_allclose([float(row[name]) for row in rows], values, rtol=1e-9)
    printed = [line.split() for line in answer.out.splitlines() if line.startswith("100.0")]
    assert_allclose(float(printed[2][1]), float(rows[1]["simulator_echo_dbm"]), atol=0.0051)  # two digits
    picture = imread("results/link.png")
    assert picture.shape[0] > 600
    assert picture.std() > 0.05


def test_results_are_not_overwritten_unasked(call: Any) -> None:
    assert call("flat", "--ranges", "100", "--out", "results").code == 0
    before = Path("results/link.csv").read_bytes()
    refused = call("flat", "--ranges", "200", "--out", "results")
    assert refused.code == 2
    assert "holds another run's link.csv" in refused.err
    assert Path("results/link.csv").read_bytes() == before
    assert call("flat", "--ranges", "200", "--out", "results", "--overwrite").code == 0
    assert Path("results/link.csv").read_bytes() != before


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--ranges", "near"), ("--ranges = 'near'", "must be numbers", "50,100,200")),
        (("--ranges", "50,,100"), ("--ranges = '50,,100'", "must be numbers")),
        (("--ranges", "50,inf"), ("--ranges = '50,inf'", "finite")),
        (("--ranges", "50,nan"), ("--ranges = '50,nan'", "finite")),
        (("--ranges", "100,5"), ("--ranges = 5", "greater than 5", "change it")),
        (("--ranges=-20"), ("--ranges = -20", "greater than 5")),
        (("--ranges", "20001"), ("--ranges = 20001", "at most 20000")),
        (("--set", "radar.heigth_m=3"), ("radar.heigth_m", "unknown key")),
        (("--set", "radar.height_m"), ("KEY=VALUE",)),
    ],
)
def test_bad_input_is_one_line(call: Any, arguments: Any, words: tuple[str, ...]) -> None:
    answer = call("choppy_sea", "--out", "results", *([arguments] if isinstance(arguments, str) else arguments))
    assert answer.code == 2
    assert answer.out == ""
    assert answer.err.count("\n") == 1
    assert answer.err.startswith("seamap-rt: ")
    for word in words:
        assert word in answer.err
    assert "Traceback" not in answer.err
    assert not Path("results").exists()


@pytest.mark.parametrize(
    "keys",
    [
        {"radar__antenna__pattern": "isotropic"},
        {"radar__waveform": "chirp", "radar__pulse_width_s": 1e-6},
        {"radar__height_m": 100.0, "scattering__decorrelation_time_s": np.inf},
        {"radar__height_m": 399.0, "scattering__nrcs": "constant"},
        {"radar__range_m": (2.0, 60.0), "radar__prf_hz": 1e5},
        {"radar__scan": "staring", "radar__interferogram": "alternating_pulse", "scattering__nrcs": "hybrid"},
    ],
)
def test_any_scene_has_a_budget(keys: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("seamap_rt.report.style.DPI", 40)  # nothing here looks at pixels
    made = write_link(scene_of(**keys), tmp_path)
    assert [path.name for path in made.files] == list(PRODUCTS)
    text = "\n".join(made.lines)
    assert "nan" not in text
    assert "None" not in text


def test_words_of_special_cases() -> None:
    chirp = "\n".join(write_link(scene_of(radar__waveform="chirp", radar__pulse_width_s=1e-6)).lines)
    assert "From nearer than 149.9 m the echo begins while the pulse is still sent" in chirp
    assert "compression gains 17.0 dB at best" in chirp
    beyond = write_link(scene_of(radar__prf_hz=1e5), ranges="100,2000").lines
    assert any("Beyond 1499" in line for line in beyond)
    assert "no beam" in "\n".join(write_link(scene_of(radar__antenna__pattern="isotropic")).lines)


def test_furthest_ranges_are_crossings() -> None:
    # Where the words say that a budget has 0 dB it has: metres are printed, half of one is 0.02 dB at 100 m.
    scene = scene_of()
    line = next(line for line in write_link(scene).lines if line.startswith("SNR is 0 dB at, simulator"))
    metres = [float(part.split()[-2]) for part in line.split(", ", 1)[1].split(",")]
    budget = link_budget(scene, metres)
    assert len(metres) == 3
    assert_allclose(np.diag(db(budget.budgets[1].snr)), 0.0, atol=0.05)


def test_figure_shows_the_numbers() -> None:
    scene = scene_of()
    curve = link_budget(scene, np.geomspace(15.0, 400.0, 80))
    gain, power, ratio, weakest = draw(scene, curve).axes
    drawn = [line for line in ratio.lines if np.size(line.get_xdata()) == 80]
    assert len(drawn) == 6
    assert_allclose(np.asarray(drawn[3].get_ydata()), db(curve.budgets[1].snr[0]), rtol=1e-12)
    assert_allclose(np.asarray(power.lines[1].get_ydata()), db(1e3 * curve.budgets[1].power), rtol=1e-12)
    assert_allclose(np.asarray(weakest.lines[-1].get_ydata()), db(curve.nrcs), rtol=1e-12)
    assert gain.get_xscale() == "log"


# ------------------------------------------------------------------------------------------------ the numbers


def test_both_budgets() -> None:
    scene = scene_of(radar__tilt_deg=2.0)
    budget = link_budget(scene, RANGES)
    assert [each.name for each in budget.budgets] == ["textbook", "simulator"]
    expected = flat_sea_power(scene.radar, budget.nrcs, RANGES)
    assert_allclose(budget.budgets[1].power, expected, rtol=1e-12)
    assert_allclose(budget.budgets[1].snr[0], expected / noise_power(scene.radar), rtol=1e-12)
    assert_allclose(db(budget.budgets[1].snr[1] / budget.budgets[1].snr[0]), 5.0 * np.log10(50.0), rtol=1e-9)


def test_eclipsed_chirp_in_the_simulators_budget_alone() -> None:
    radar = RadarSettings(waveform="chirp", pulse_width_s=1e-6)
    share = simulated_power(radar, RANGES) / flat_sea_power(radar, 1.0, RANGES)
    assert 0.05 < share[0] < 0.5 < share[1] < 1.0  # cT/2 is 150 m
    assert share[2] == 1.0


def test_mean_sea_is_the_scenes_model() -> None:
    grazing, state = np.degrees(np.arcsin(5.0 / RANGES)), sea_state_from_wind(8.0)
    nrl = nrcs_gregers_hansen12(grazing, state, 10e9, "VV")
    got, name = mean_sea(scene_of(), RANGES)
    assert_allclose(got, nrl, rtol=1e-12)
    assert name == "Gregers-Hansen & Mittal 2012"
    got, name = mean_sea(scene_of(scattering__nrcs="constant", scattering__nrcs_db=-33.0), RANGES)
    assert_allclose(db(got), -33.0, rtol=1e-12)
    assert name == "constant"
    got, name = mean_sea(scene_of(scattering__calibrated_to="none"), RANGES)
    assert_allclose(got, nrl, rtol=1e-12)
    assert "NRL" in name
    assert "stand-in" in name
    for model in ("nrl", "none"):
        got, name = mean_sea(scene_of(scattering__calibrated_to=model, scattering__wind_speed_m_s=25.0), RANGES)
        assert np.all(np.isfinite(got))
        assert "from its 13.2 m/s on by theory" in name
    got, name = mean_sea(scene_of(scattering__nrcs="hybrid"), RANGES)
    assert "mean over wind directions" in name


def test_default_ranges_lie_in_the_window() -> None:
    assert ranges_of(None, scene_of()).tolist() == [15.0, 20.0, 30.0, 50.0, 70.0, 100.0, 150.0, 200.0, 300.0, 400.0]
    high = ranges_of(None, scene_of(radar__height_m=30.0))
    assert 30.0 < high[0] < 35.0  # steeper than 60° no clutter model goes
    assert np.all(np.diff(ranges_of(None, scene_of(radar__height_m=399.0))) > 0.0)


def test_claim_of_the_study() -> None:
    # −55 dB at 100 m: as the study has it with 60 % of the aperture and its 50 pulses added without phase.
    rows = {(row.assumption.split(",")[1].strip(), row.integration): row for row in claim_minimum_nrcs(RadarSettings())}
    assert len(rows) == 12
    assert_allclose(rows["100 % of the aperture", "one pulse"].minimum_db, -51.2, atol=0.05)
    assert_allclose(rows["60 % of the aperture", "non-coherent"].minimum_db, -46.77 - 8.49, atol=0.01)
    assert rows["60 % of the aperture", "non-coherent"].met
    assert not any(row.met for (_, way), row in rows.items() if way == "one pulse")
    assert all(row.met for (_, way), row in rows.items() if way == "coherent")
    assert not rows["with its losses", "non-coherent"].met  # by a third of a decibel
    for row in rows.values():
        if row.assumption.startswith("textbook"):
            # σ0 min ∝ R³ sec ψ; sec ψ departs from its value at 100 m by at most 0.02 dB from 50 to 280 m.
            assert_allclose(30.0 * np.log10(row.reached_m / 100.0), -55.0 - row.minimum_db, atol=0.03)
        assert row.met == (row.reached_m >= 100.0)


def test_claim_reaches_where_it_says() -> None:
    radar = RadarSettings()
    row = claim_minimum_nrcs(radar)[-2]
    assert (row.assumption, row.integration) == ("simulator, with its losses", "non-coherent")
    power = simulated_power(radar, np.array([row.reached_m]))
    assert_allclose(db(noise_power(radar) / power) - 5.0 * np.log10(50.0), -55.0, atol=0.01)


def test_search_ends_at_the_unambiguous_range() -> None:
    loud = scene_of(radar__transmit_power_w=1e6, radar__prf_hz=2e4)
    line = next(line for line in write_link(loud).lines if line.startswith("SNR is 0 dB at, textbook"))
    assert f"beyond {unambiguous_range_m(loud.radar):.0f} m" in line


def test_two_line_headings() -> None:
    assert link._split_unit("SNR dB one pulse") == ("SNR one pulse", "dB")
    assert link._split_unit("range") == ("range", "")
