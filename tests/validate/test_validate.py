"""The runner and the page: what is red, what is named, what is left behind."""

from __future__ import annotations

import json
import sys
import textwrap
import types
from html.parser import HTMLParser
from pathlib import Path
from typing import get_args

import pytest

from seamap_rt import lazy
from seamap_rt.cli.studying import validate as validate_command
from seamap_rt.errors import InputError
from validation.report import Group, ValidationResult, validate
from validation.report.discovery import cases_folder, load_cases, names_in

HEAD = """
from validation.report import Case, Check, Outcome
from validation.report.checks import within

def case(name, run, group="closed forms", **more):
    return Case(name, group, f"Title of {name}", "why", "how", "what must come out", run, **more)

def green(full):
    return Outcome((within("a length", 1.001, 1.0, 0.01, "m"),))
"""


def modules(folder: Path, **bodies: str) -> Path:
    """A folder of case modules, each headed by the same helpers."""
    cases = folder / "validation" / "cases"
    cases.mkdir(parents=True)
    for name, body in bodies.items():
        (cases / f"{name}.py").write_text(HEAD + textwrap.dedent(body), encoding="utf-8")
    return cases


def ran(folder: Path, cases: Path, **asked) -> ValidationResult:
    return validate(folder / "out", cases=cases, **asked)


class Tags(HTMLParser):
    """Opening and closing tags that do not meet, and every address that the page would load."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.loads: list[str] = []
        self.ids: list[str] = []
        self.links: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in ("meta", "link", "img", "br"):
            self.open.append(tag)
        for name, value in attrs:
            if name in ("src", "srcset") or (name == "href" and tag == "link"):
                self.loads.append(value or "")
            if name == "href" and tag == "a":
                self.links.append(value or "")
            if name == "id":
                self.ids.append(value or "")

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def read(page: str) -> Tags:
    tags = Tags()
    tags.feed(page)
    assert tags.open == []
    return tags


FIGURE = """
    import numpy as np
    from seamap_rt.report import style

    @style.styled
    def drawn():
        figure = style.new_figure(1.0)
        style.graph(style.place(figure, 0.5, 0.3, 2.0, 0.4), "x", "y", "a figure")
        return figure
"""


def test_green_red_and_for_the_record(tmp_path: Path) -> None:
    cases = modules(
        tmp_path,
        some=FIGURE
        + """
    def red(full):
        checks = within("a height", 2.0, 1.0, 0.01, "m"), within("a length", 1.0, 1.0, 0.01)
        return Outcome(checks, drawn(), "seen <so>")

    def told(full):
        return Outcome((Check("seconds", "3.2 s", "—", None),), verdict="only if calm", assumption="a calm sea")

    CASES = [case("told", told, "claims of 2004"), case("red_one", red, "speed"), case("green_one", green)]
    """,
    )
    result = ran(tmp_path, cases)
    assert (result.passed, result.failed, result.recorded) == (1, 1, 1)
    assert [done.case.name for done in result.done] == ["green_one", "told", "red_one"]  # the groups' order
    assert "1 green, 1 red, 1 for the record" in result.summary
    told = json.loads((tmp_path / "out" / "metrics.json").read_text(encoding="utf-8"))
    assert {name: case["passed"] for name, case in told["cases"].items()} == {
        "green_one": True,
        "told": None,
        "red_one": False,
    }
    assert told["cases"]["red_one"]["checks"][0] == {
        "what": "a height",
        "found": "2.000 m",
        "expected": "1.000 ± 0.01 m",
        "passed": False,
    }
    assert told["cases"]["told"]["verdict"] == "only if calm"
    assert told["versions"]["seamap_rt"]
    page = (tmp_path / "out" / "validation.html").read_text(encoding="utf-8")
    tags = read(page)
    assert all(each.startswith("data:") for each in tags.loads)  # the page needs no other file
    assert len([each for each in tags.loads if each.startswith("data:image/png")]) == 1
    assert {link.removeprefix("#") for link in tags.links} == {"red_one", "more", "metrics.json"}
    assert all(f"--only {name}<" in page for name in told["cases"])
    assert "seen &lt;so&gt;" in page
    assert page.count("✗ red") == 4  # a warning, the table of all, its title and the check itself
    assert "only if calm" in page


def test_an_exception_is_a_red_case_and_the_others_go_on(tmp_path: Path) -> None:
    cases = modules(
        tmp_path,
        some="""
    def breaks(full):
        raise RuntimeError("no\\nsea")

    def leaves(full):
        raise SystemExit("2")

    def forgets(full):
        pass

    CASES = [case("breaks", breaks), case("leaves", leaves), case("forgets", forgets), case("fine", green)]
    """,
    )
    result = ran(tmp_path, cases)
    assert [done.passed for done in result.done] == [False, False, False, True]
    assert result.done[0].checks[0].found == "RuntimeError: no sea"
    page = (tmp_path / "out" / "validation.html").read_text(encoding="utf-8")
    assert "RuntimeError: no sea" in page
    assert "in breaks" in page  # the trace, folded away
    read(page)


def test_a_module_that_cannot_be_loaded_is_a_red_case(tmp_path: Path) -> None:
    cases = modules(
        tmp_path,
        broken="import no_such_module_at_all",
        empty="",
        twice='CASES = [case("fine", green)]',
        fine='CASES = [case("fine", green)]',
    )
    done_by_name = {done.case.name: done for done in ran(tmp_path, cases).done}
    assert {name: done.passed for name, done in done_by_name.items()} == {
        "fine": True,
        "broken": False,
        "empty": False,
        "twice": False,
    }
    assert "no_such_module_at_all" in done_by_name["broken"].checks[0].found
    assert "given twice: fine" in done_by_name["twice"].checks[0].found


def test_full_reaches_the_case_and_long_cases_wait_for_it(tmp_path: Path) -> None:
    cases = modules(
        tmp_path,
        some="""
    def asked(full):
        return Outcome((Check("full", str(full), "—", None),))

    CASES = [case("asked", asked), case("long", asked, full_only=True)]
    """,
    )
    assert [done.case.name for done in ran(tmp_path, cases).done] == ["asked"]
    long = ran(tmp_path, cases, full=True, overwrite=True)
    assert [(done.case.name, done.checks[0].found) for done in long.done] == [("asked", "True"), ("long", "True")]
    with pytest.raises(InputError, match=r"--only long: takes long .* add --full"):
        ran(tmp_path, cases, only=["long"], overwrite=True)
    assert [done.case.name for done in ran(tmp_path, cases, only=["asked"], overwrite=True).done] == ["asked"]
    with pytest.raises(InputError, match="--only askd: no such case; there is asked"):
        ran(tmp_path, cases, only=["askd"], overwrite=True)
    assert (tmp_path / "out" / "validation.html").exists()  # a refusal takes nothing away


def test_another_runs_results_stay(tmp_path: Path) -> None:
    cases = modules(tmp_path, some='CASES = [case("fine", green)]')
    ran(tmp_path, cases)
    before = (tmp_path / "out" / "metrics.json").read_bytes()
    with pytest.raises(InputError, match=r"holds another run's validation\.html"):
        ran(tmp_path, cases)
    assert (tmp_path / "out" / "metrics.json").read_bytes() == before
    ran(tmp_path, cases, overwrite=True)
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["metrics.json", "validation.html"]


def test_an_older_page_never_stands_beside_a_newer_run(tmp_path: Path) -> None:
    out = tmp_path / "out"
    cases = modules(
        tmp_path,
        some=f"""
    from pathlib import Path

    def look(full):
        return Outcome((Check("files", str(sorted(each.name for each in Path({str(out)!r}).iterdir())), "[]", None),))

    CASES = [case("look", look)]
    """,
    )
    ran(tmp_path, cases)
    assert ran(tmp_path, cases, overwrite=True).done[0].checks[0].found == "['.seamap-rt.lock']"


def test_cases_are_those_of_the_checkout_or_of_the_wheel(tmp_path: Path) -> None:
    assert (cases_folder().parent / "reference").is_dir()
    with pytest.raises(InputError, match="validation cases: none in"):
        cases_folder(tmp_path / "validation")


def test_another_package_of_the_judges_name_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "validation", types.ModuleType("validation"))
    monkeypatch.delitem(sys.modules, "validation.report")
    with pytest.raises(InputError, match=r"^validation\.report: Python finds another package of that name"):
        validate_command()


def test_a_library_that_is_missing_is_named_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(_: str) -> None:
        raise ModuleNotFoundError("No module named 'matplotlib'", name="matplotlib")

    monkeypatch.setattr(lazy, "import_module", missing)
    with pytest.raises(ModuleNotFoundError, match="matplotlib"):
        lazy.judge("report")


def test_the_packages_own_cases_load_and_say_what_they_ask() -> None:
    cases = load_cases(cases_folder())
    assert len(cases) > 30
    assert {case.name for case in cases} == {name for path in cases_folder().glob("*.py") for name in names_in(path)}
    assert {case.group for case in cases} <= set(get_args(Group)) - {"cases that cannot be loaded"}
    for case in cases:
        assert case.name.isidentifier()
        assert case.name == case.name.lower()
        for words in (case.title, case.rationale, case.setup, case.expectation):
            assert words
            assert words == words.strip()


def test_an_unknown_name_is_refused_before_a_module_is_loaded(tmp_path: Path) -> None:
    cases = modules(
        tmp_path, one='raise SystemExit("loaded")\nCASES = [case("one", green)]', two='CASES = [case("two", green)]'
    )
    with pytest.raises(InputError, match="--only tow: no such case; there is two"):
        load_cases(cases, ["tow"])
    assert [each.name for each in load_cases(cases, ["two"])] == ["two"]


def test_what_is_done_is_kept_before_the_next_case_begins(tmp_path: Path) -> None:
    """A process that is killed, or runs out of memory, in a long case loses that case alone."""
    cases = modules(
        tmp_path,
        some="""
    import json
    from pathlib import Path
    from validation.report.checks import at_least

    def look(full):
        kept = json.loads(Path(HERE, "metrics.json").read_text(encoding="utf-8"))
        return Outcome((at_least("cases kept", len(kept["cases"]), 1),))

    CASES = [case("first", green), case("second", look)]
    """.replace("HERE", repr(str(tmp_path / "out"))),
    )
    assert ran(tmp_path, cases).passed == 2


def test_an_interruption_leaves_the_page_of_what_is_done(tmp_path: Path) -> None:
    cases = modules(
        tmp_path,
        some="""
    def stop(full):
        raise KeyboardInterrupt

    CASES = [case("first", green), case("second", stop), case("third", green)]
    """,
    )
    with pytest.raises(KeyboardInterrupt, match=r"1 of 3 cases are done; .*validation\.html shows them"):
        ran(tmp_path, cases)
    page = (tmp_path / "out" / "validation.html").read_text(encoding="utf-8")
    assert "Interrupted: 1 of 3 cases were run." in page
    assert list(json.loads((tmp_path / "out" / "metrics.json").read_text(encoding="utf-8"))["cases"]) == ["first"]


def test_cases_import_the_package_by_its_own_name(tmp_path: Path) -> None:
    cases = modules(
        tmp_path,
        some="""
    from validation import FIGURES

    def late(full):
        from validation.claims import radar
        return Outcome((Check("both", "", "", radar.__name__ == "validation.claims.radar"),))

    CASES = [case("late", late)]
    """,
    )
    path = list(sys.path)
    assert ran(tmp_path, cases).passed == 1
    assert sys.path == path


def test_truth_values_of_numpy_are_plain_in_the_files(tmp_path: Path) -> None:
    cases = modules(
        tmp_path,
        some="""
    import numpy as np

    def drawn(full):
        return Outcome((Check("x", "1", "2", np.float64(1.0) > 2.0),))

    CASES = [case("numpy_says_no", drawn)]
    """,
    )
    assert ran(tmp_path, cases).failed == 1
    told = json.loads((tmp_path / "out" / "metrics.json").read_text(encoding="utf-8"))
    assert told["cases"]["numpy_says_no"]["checks"][0]["passed"] is False


def test_progress_names_each_case(tmp_path: Path) -> None:
    cases = modules(tmp_path, some='CASES = [case("one", green), case("two", green)]')
    said: list[str] = []
    ran(tmp_path, cases, progress=said.append)
    assert said == ["case 1 of 2: Title of one", "case 2 of 2: Title of two"]
