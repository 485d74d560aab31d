"""Text that came from anywhere never becomes part of a string that a browser reads as a language.

NiceGUI reads `props("…")`, where `:prop` is JavaScript, `classes("…")` and `style("…")` as small languages of their
own, and hands HTML, CSS and JavaScript on. All of these are constants of the source; what varies is set by key.
"""

from __future__ import annotations

import ast
import importlib
from pathlib import Path

import jinja2
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from jinja2 import nodes

from seamap_rt.app.folders import address
from seamap_rt.io.text import toml_string

_PACKAGE = Path(__file__).parents[2] / "seamap_rt"
_CODE = {"props", "classes", "style", "default_props", "default_classes", "default_style"}
_CODE |= {"add_css", "add_scss", "add_sass", "add_head_html", "add_body_html", "run_javascript", "js_handler"}
_NEVER = {"html", "markdown", "restructured_text", "interactive_image", "mermaid", "editor", "chat_message", "log"}
_NEVER |= {"aggrid", "echart", "highchart", "tree", "query", "add_slot_template"}  # whose options are code


def _is_constant(node: ast.AST, module: object) -> bool:
    """A literal, a choice among some, or a table of strings of the module under a name in capitals."""
    match node:
        case ast.Constant():
            return True
        case ast.IfExp(body=body, orelse=orelse):
            return _is_constant(body, module) and _is_constant(orelse, module)
        case ast.Subscript(value=ast.Name(id=name)):
            table = getattr(module, name, None) if name.isupper() else None
            return isinstance(table, dict) and all(isinstance(each, str) for each in table.values())
        case ast.Name(id=name):
            return name.isupper() and isinstance(getattr(module, name, None), str)
        case ast.JoinedStr(values=values):  # of JavaScript: numbers of elements, and JSON
            return all(isinstance(each, ast.Constant) or _is_escaped(each) for each in values)
    return False


def _is_escaped(node: ast.AST) -> bool:
    return isinstance(node, ast.FormattedValue) and (
        (isinstance(node.value, ast.Attribute) and node.value.attr == "id")
        or (isinstance(node.value, ast.Call) and ast.unparse(node.value.func) == "json.dumps")
    )


def _wrong(source: str, module: object) -> list[str]:
    tree = ast.parse(source)
    at_once = {id(node.func if isinstance(node, ast.Call) else node.value)
               for node in ast.walk(tree) if isinstance(node, ast.Call | ast.Subscript)}  # fmt: skip
    found = [ast.unparse(node) for node in ast.walk(tree)
             if isinstance(node, ast.Attribute) and node.attr == "props" and id(node) not in at_once]  # fmt: skip
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call):
            continue
        name = node.func.attr if isinstance(node.func, ast.Attribute) else ""
        given = [*node.args, *(each.value for each in node.keywords)] if name in _CODE else []
        if name == "run_javascript":
            given = node.args[:1]
        given += [each.value for each in node.keywords if each.arg in ("js_handler", "innerHTML", "sanitize")]
        if name == "add_slot":
            given += node.args[1:]
        if name == "table" and not any(
            each.arg == "columns" and isinstance(each.value, ast.Name) and each.value.id.isupper()
            for each in node.keywords
        ):
            found.append(ast.unparse(node))  # columns may hold code; rows are text
        if name in _NEVER and ast.unparse(node.func).startswith("ui."):
            found.append(ast.unparse(node))
        found += [ast.unparse(node) for each in given if not _is_constant(each, module)]
        found += [ast.unparse(node) for each in node.keywords if each.arg is None and name in _CODE]
    return found


@pytest.mark.parametrize("path", sorted((_PACKAGE / "app").glob("*.py")), ids=lambda path: path.stem)
def test_what_the_page_hands_to_a_language_is_constant(path: Path) -> None:
    module = importlib.import_module(f"seamap_rt.app.{path.stem}")
    assert _wrong(path.read_text(encoding="utf-8"), module) == []


@pytest.mark.parametrize(
    "source",
    [
        "x.props(f'aria-label={name}')",
        "x.props(name)",
        "x.props('a' + name)",
        "x.props('a={}'.format(name))",
        "x.props('a' if name else name)",
        "x.props(**name)",
        "f = x.props",
        "x.classes(replace=name)",
        "x.style(f'width: {name}')",
        "ui.html('x')",
        "ui.markdown(name)",
        "ui.run_javascript(f'f({name})')",
        "x.on('click', js_handler=f'f({name})')",
        "x.add_slot('body', name)",
        "ui.add_css(name)",
    ],
)
def test_the_law_finds_what_it_is_to_find(source: str) -> None:
    assert _wrong(source, object())


# -------------------------------------------------------------------------------------------------- other languages


@pytest.mark.parametrize("path", sorted(_PACKAGE.rglob("*.j2")), ids=lambda path: path.name)
def test_templates_escape_all_that_they_are_given(path: Path) -> None:
    """Only constants are exempted, and nothing is put into a script, a style, or the name of an address."""
    tree = jinja2.Environment().parse(path.read_text(encoding="utf-8"))
    for each in tree.find_all(nodes.Filter):
        if each.name == "safe":
            assert isinstance(each.node, nodes.CondExpr | nodes.Const), path
            for part in (each.node.expr1, each.node.expr2) if isinstance(each.node, nodes.CondExpr) else ():
                assert part is None or isinstance(part, nodes.Const)
    text = path.read_text(encoding="utf-8")
    for tag in ("script", "style"):
        for piece in text.split(f"<{tag}")[1:]:
            assert "{{" not in piece.split(f"</{tag}>")[0]


def test_every_template_is_rendered_with_escapes() -> None:
    """A template's environment says so itself: Jinja's own default is not to escape."""
    for path in _PACKAGE.rglob("*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and ast.unparse(node.func) in ("jinja2.Environment", "jinja2.Template"):
                told = {each.arg: each.value for each in node.keywords}
                assert isinstance(told.get("autoescape"), ast.Constant), path
                assert told["autoescape"].value is True, path  # type: ignore[attr-defined]


@given(st.text())
@example('```\n<img src="http://elsewhere">')
def test_a_scene_as_text_has_no_line_of_a_value_alone(text: str) -> None:
    """It is shown as code, which a line of three backquotes would end."""
    assert len(toml_string(text).splitlines()) == 1
    assert toml_string(text).startswith('"')


@given(st.text(st.characters(exclude_categories=["Cs"]), min_size=1))
@example("a?b#c%2e/../d")
@example('x" onerror="y')
def test_an_address_of_a_product_has_the_names_letters_and_no_meaning_of_them(name: str) -> None:
    told = address(name, "maps.nc")
    assert told.isascii()
    assert not set(told) & set(" \"'<>`?#\\{}\r\n\0:")
