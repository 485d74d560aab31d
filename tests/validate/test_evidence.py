"""What the READMEs quote is what results hold, studies judge code that exists, a result's page is its tables."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from validation import evidence

ROOT = Path(__file__).parents[2]
READMES = ("README.md", "validation/README.md")
MODELS = [f"validation/models/{page.name}" for page in sorted((ROOT / "validation/models").glob("*.md"))]


def quoted(readme: str) -> list[tuple[str, str, str]]:
    """(words before a comment since the last heading or comment, figure, path) of each figure that a README quotes."""
    made, start = [], 0
    text = (ROOT / readme).read_text(encoding="utf-8")
    for found in re.finditer(r"<!-- \S+ = .*? -->|^#[^\n]*", text, flags=re.MULTILINE | re.DOTALL):
        made += [(text[start : found.start()], *entry) for entry in evidence.quotes(found[0])]
        start = found.end()
    return made


@pytest.mark.parametrize("readme", [*READMES, *MODELS])
def test_each_quoted_figure_is_that_of_its_result(readme: str) -> None:
    """Every figure with a source stands in the words before it and equals its result to its own digits."""
    figures = quoted(readme)
    whole = r"(?<![\d.,]){}(?!\d|[.,]\d)"
    wrong = [
        f"{figure}: not in the words before"
        for words, figure, _ in figures
        if not re.search(whole.format(re.escape(figure)), words)
    ]
    wrong += [
        f"{figure}: {path} is {evidence.figure(path)}"
        for _, figure, path in figures
        if not evidence.agrees(figure, path)
    ]
    assert readme in MODELS or len(figures) > 10
    assert not wrong, "; ".join(wrong)


@pytest.mark.parametrize("readme", READMES)
def test_each_verdict_has_a_source(readme: str) -> None:
    """Every section that shows a figure table with a verdict, or names a study's command, states what it quotes."""
    text = (ROOT / readme).read_text(encoding="utf-8")
    for section in re.split(r"^#+ ", text, flags=re.MULTILINE):
        if "| verdict |" in section:
            assert section.count("| verdict |") <= section.count("<!-- "), section[:80]


def test_the_table_of_versions_is_that_of_the_results() -> None:
    """The table is what the results say, and the page stays short."""
    text = evidence.README.read_text(encoding="utf-8")
    assert text == evidence.with_versions(text)
    assert len(text.encode()) <= 25 * 1024  # what a sceptic reads


@pytest.mark.parametrize("name", evidence.STUDIES)
def test_a_study_runs_a_module_that_exists_on_code_that_exists(name: str) -> None:
    study = evidence.STUDIES[name]
    module = study.words(1)[1].replace(".", "/")
    assert any((ROOT / f"{module}{end}").exists() for end in (".py", "/__main__.py")), module
    assert all((ROOT / each).exists() for each in study.files), study.files
    assert study.kind in evidence.KINDS
    assert (study.draw is not None) == ("{draw}" in study.command)
    assert study.draw is None or study.kind == "validate"
    assert ("12345" in study.words(12345)) == (study.draw is not None)


def test_each_result_is_of_a_study_that_can_be_run_again() -> None:
    """Or of one that says why it is run by hand: what no code makes any more is no evidence."""
    on_file = {path.stem for path in evidence.RESULTS.glob("*.json")}
    assert on_file - set(evidence.STUDIES) == set(evidence.BY_HAND)
    for name in evidence.BY_HAND:
        module = evidence.result(name)["command"].split()[2].replace(".", "/")
        assert (ROOT / f"{module}.py").exists(), name


@pytest.mark.parametrize("path", sorted(evidence.RESULTS.glob("*.json")), ids=lambda path: path.stem)
def test_a_result_says_where_it_is_from(path: Path) -> None:
    """Command, commit, date, kind and subject; machine and seconds unless it is carried; rows under its columns."""
    made = evidence.result(path.stem)
    assert made["command"].startswith("python ")
    assert re.match(r"[0-9a-f]{7}", made["commit"])
    assert re.match(r"20\d\d-\d\d-\d\d", made["date"])
    assert made["kind"] in evidence.KINDS
    assert made["subject"]
    assert made.get("carried") or (made["machine"] and made["seconds"] > 0.0)
    assert made["tables"]
    assert path.with_suffix(".md").exists()
    for table in made["tables"]:
        assert all(len(row) <= 1 + len(table["columns"]) for row in table["rows"] if table["columns"]), table["title"]


@pytest.mark.parametrize("path", sorted((ROOT / "validation").glob("**/*.py")), ids=lambda path: path.stem)
def test_a_study_names_its_options_where_it_says_what_it_does(path: Path) -> None:
    """Each keyword of `options` stands as --keyword in the module's docstring, which --help prints."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for call in (node for node in ast.walk(tree) if isinstance(node, ast.Call) and ast.unparse(node.func) == "options"):
        flags = [f"--{(each.arg or '').replace('_', '-')}" for each in call.keywords]
        assert not [flag for flag in flags if flag not in (ast.get_docstring(tree) or "")]


def test_tables_of_what_studies_print() -> None:
    """Markdown rows, aligned columns and single lines become rows by name; what has no number is a title."""
    printed = "Heights:\n\n| sea | rms | bias |\n|---|---|---|\n| calm | 0.01 m | −2 mm |\n\n"
    printed += "sides\nlow   1.5  2\n12 of 24 hold"
    heights, sides = evidence.tables(printed)
    assert [len(each["rows"]) for each in evidence.tables("| a | b |\n|---|---|\n| 1 | 2 |\nlow   1.5  2")] == [1, 1]
    assert heights == {"title": "Heights", "columns": ["rms", "bias"], "rows": [["calm", "0.01 m", "−2 mm"]]}
    assert sides == {"title": "sides", "columns": [], "rows": [["low", "1.5", "2"], ["12 of 24 hold", "12", "24"]]}


@pytest.mark.parametrize(
    ("quote", "value", "right"), [("0.99", 0.991, True), ("0.99", 0.996, False), ("−3", -3.4, True)]
)
def test_a_quote_holds_to_its_own_digits(
    monkeypatch: pytest.MonkeyPatch, quote: str, value: float, right: bool
) -> None:
    monkeypatch.setattr(evidence, "figure", lambda _: value)
    assert evidence.agrees(quote, "any :: row :: column") is right


def test_a_study_leaves_its_rows_on_file_for_the_number_that_is_asked_for(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A study runs as a process with --draw's number; its result is kept until its subject changes."""
    study = evidence.Study("validate", "draws {draw} --of seas --count 2", "sea", 841)
    monkeypatch.setitem(evidence.STUDIES, "drawn", study)
    monkeypatch.setattr(evidence, "RESULTS", tmp_path)
    assert evidence.changes("drawn") is None
    made, text = evidence.make("drawn", 7)
    assert [row[0].split()[0] for table in made["tables"] for row in table["rows"]] == ["seas_7_0", "seas_7_1"]
    evidence.write("drawn", made, text)
    assert evidence.result("drawn") == made
    assert "seas_7_1" in (tmp_path / "drawn.md").read_text(encoding="utf-8")
    assert evidence.changes("drawn") == 0


def test_commits_that_change_no_bit_of_a_subject_leave_its_results_current(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(evidence, "ROOT", tmp_path)
    monkeypatch.setattr(evidence, "RESULTS", tmp_path)
    evidence.git("init", "-q")
    counts = []
    for number, subject in enumerate(("Add a sea", "Move the sea (no bit changed)", "Fix the sea")):
        (tmp_path / "sea").write_text(str(number), encoding="utf-8")
        evidence.git("add", "sea")
        evidence.git("-c", "user.name=a", "-c", "user.email=a@b", "commit", "-q", "-m", subject)
        if not number:
            first = {"commit": evidence.git("log", "-1", "--format=%h"), "subject": ["sea"], "date": "", "tables": []}
            evidence.write("waves", {"kind": "debug", "command": "", **first}, "")
        counts.append(evidence.changes("waves"))
    assert counts == [0, 0, 1]
    fix = evidence.git("log", "-1", "--format=%H")[:8]
    for reached, count in (("waves", 0), ("ships sea", 1)):  # packages that the fix changes
        monkeypatch.setitem(evidence.CHANGED, fix, reached)
        assert evidence.changes("waves") == count
