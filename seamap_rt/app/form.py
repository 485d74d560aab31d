"""The form on the page: fields by section, refusals at their fields, changed keys marked, one line of help below."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from nicegui import ui

from ..report.keys import is_switch, matters, read_value, shown_value
from .draft import Draft, Field, Part, list_sections, parts_of
from .uploads import kind_of_field, upload_button

_OPEN = ("", "sea.waves.0", "radar")
_FIRST = {  # what is asked first, in this order; the rest of a section is behind "more"
    "": "seed turns",
    "sea": "depth_m model",
    "sea.waves": "spectrum significant_wave_height_m peak_period_s height_m wavelength_m wave_from_deg wind_speed_m_s",
    "radar": "height_m baseline_m transmit_power_w range_m sector_deg frequency_hz rotation_rpm",
    "radar.antenna": "azimuth_beamwidth_deg elevation_beamwidth_deg",
    "scattering": "wind_speed_m_s wind_from_deg polarization",
    "platform": "motion speed_m_s heading_deg",
    "tracing": "tracer",
    "retrieval": "cell_range_m cell_azimuth_deg estimator",
    "prediction": "lead_s turns",
    "prediction.quiet": "elevation_m duration_s",
}


class Form:
    """The fields of a draft. changed: called after each change; it is given the key."""

    def __init__(self, draft: Draft, changed: Callable[[str], None]) -> None:
        self.draft, self._changed = draft, changed
        self._fields: dict[str, tuple[Field, Any]] = {}
        self._open: set[str] = set(_OPEN)
        self._more: set[str] = set()
        self._elsewhere = ui.label().classes("text-negative text-sm").props("role=alert")
        self._body = ui.column().classes("w-full gap-1")
        with ui.element("div").classes("sticky bottom-0 w-full z-10 help-line"):
            self._help = ui.label("Choose a field: this line explains it.").classes("text-xs").props("aria-live=polite")
        self.rebuild()

    # --------------------------------------------------------------------------------------------- building

    def rebuild(self) -> None:
        """Make all fields anew: the sections or the switches have changed."""
        self._fields.clear()
        self._body.clear()
        with self._body:
            for part in parts_of(self.draft.tree):
                self._section(part)
            self._make_add_buttons()
        self.refresh()

    def _section(self, part: Part) -> None:
        shown = [field for field in part.fields if self._is_shown(field)]
        if not shown:
            return
        with (
            ui.expansion(part.label, value=part.path in self._open)
            .classes("w-full section")
            .props("dense") as expansion
        ):
            body = ui.column().classes("w-full gap-2 pb-2")
        expansion.mark(f"section-{part.path or 'run'}")

        def toggle(is_open: bool) -> None:
            (self._open.add if is_open else self._open.discard)(part.path)
            if is_open and not body.default_slot.children:
                with body:
                    self._fill(part, shown)
                self.refresh()

        expansion.on_value_change(lambda e: toggle(e.value))
        if part.path in self._open:
            toggle(True)

    def _fill(self, part: Part, shown: list[Field]) -> None:
        wanted = _FIRST.get(".".join(name for name in part.path.split(".") if not name.isdigit()), "").split()
        leaves = {field.key.rsplit(".", 1)[-1]: field for field in shown}
        first = [leaves[name] for name in wanted if name in leaves] or shown[:4]
        rest = [field for field in shown if field not in first]
        with ui.grid().classes("w-full gap-x-3 gap-y-1 grid-cols-1 sm:grid-cols-2"):
            for field in first:
                self._field(field)
        if rest:
            more = ui.expansion("more", value=part.path in self._more).classes("w-full text-sm")
            more.props("dense dense-toggle")
            more.on_value_change(lambda e: (self._more.add if e.value else self._more.discard)(part.path))
            with more, ui.grid().classes("w-full gap-x-3 gap-y-1 grid-cols-1 sm:grid-cols-2"):
                for field in rest:
                    self._field(field)
        if part.many:
            ui.button("Delete", icon="delete", on_click=lambda: self._delete(part)).props("flat dense size=sm no-caps")

    def _delete(self, part: Part) -> None:
        """An entry of a list, when it is asked for twice."""

        def confirm() -> None:
            dialog.close()
            self._restructure(self.draft.remove, part.path)

        with ui.dialog(value=True) as dialog, ui.card():
            ui.label(f"Delete {part.label} from the design? Undo brings it back.")
            with ui.row():
                ui.button("Delete it", icon="delete", on_click=confirm).props("no-caps")
                ui.button("Keep it", on_click=dialog.close).props("flat no-caps")

    def _make_add_buttons(self) -> None:
        with ui.row().classes("gap-2 pt-2"):
            for each in list_sections():
                kind = "jonswap" if "jonswap" in each.kinds else ""
                ui.button(
                    f"Add {each.label.lower().removesuffix('s')}" if each.label != "Waves" else "Add waves",
                    icon="add",
                    on_click=partial(self._restructure, self.draft.add, each.path, each.tag, kind),
                ).props("flat dense size=sm no-caps")

    def _restructure(self, change: Callable[..., None], *arguments: str) -> None:
        before = {part.path for part in parts_of(self.draft.tree)}
        change(*arguments)
        self._open |= {part.path for part in parts_of(self.draft.tree)} - before  # what was added is asked for now
        self.rebuild()
        self._changed(arguments[0])

    def _is_shown(self, field: Field) -> bool:
        return matters(field.key, self.draft.value) or field.key in self.draft.refused

    # ---------------------------------------------------------------------------------------------- one field

    def _field(self, field: Field) -> None:
        label = f"{field.label} ({field.unit})" if field.unit else field.label
        if field.kind == "switch":
            element: Any = ui.switch(label)
        elif field.kind == "choice":
            left_out = {"": f"— {field.default}".strip()} if field.optional else {}
            element = ui.select({**left_out, **{each: _choice_in_words(each) for each in field.choices}}, label=label)
            element.props("dense outlined options-dense hide-bottom-space")
        else:
            element = ui.input(label, placeholder=field.default if len(field.default) < 48 else "left out")
            element.props("dense outlined hide-bottom-space debounce=120 spellcheck=false autocomplete=off stack-label")
            if field.kind == "number":
                element.props("inputmode=decimal")
        element.on(f"update:{element.VALUE_PROP}", partial(self._take_edit, field, element), [])
        kind = kind_of_field(field.key)
        if kind is not None:

            def take_upload(path: Path) -> None:
                element.value = str(path)
                self._take_edit(field, element)

            def show_error(line: str) -> None:
                element.error = line or None

            with element.add_slot("append"):
                upload_button(self.draft.roots, kind, show_error, take_upload)
        if field.kind != "switch":
            element.without_auto_validation()  # which would clear, after each change, what is refused
        element.classes("w-full").mark(field.key)
        element.props["data-key"] = field.key
        element.on("focusin", lambda: self._help.set_text(field.help))
        self._fields[field.key] = (field, element)

    def _take_edit(self, field: Field, element: Any) -> None:
        """What a person has typed or chosen."""
        value, leaf = element.value, field.key.rsplit(".", 1)[-1]
        if field.kind in ("number", "list"):
            value = read_value(field.key, value or "")
        elif value in ("", None):
            value = "" if field.key == "title" else None
        if leaf == "spectrum":
            self.draft.kind(field.key.rsplit(".", 1)[0], "spectrum", str(value))
        else:
            self.draft.set(field.key, value)
        if is_switch(field.key):
            self.rebuild()
        else:
            self.refresh(field.key)
        self._changed(field.key)

    # ------------------------------------------------------------------------------------------------ refreshing

    def refresh(self, origin: str = "") -> None:
        """Values, refusals and marks of all fields that are there; the origin's value stays as it was typed."""
        changed, refused = self.draft.changes, dict(self.draft.refused)
        for key, (field, element) in self._fields.items():
            if key != origin:
                self._fill_value(field, element)
            line = refused.pop(key, None)
            if field.kind != "switch":
                element.error = line
            element.classes("changed" if key in changed else None, remove=None if key in changed else "changed")
            element.classes("sm:col-span-2" if line else None, remove=None if line else "sm:col-span-2")
        self._elsewhere.set_text(" · ".join(refused.values()))
        self._elsewhere.set_visibility(bool(refused))

    def _fill_value(self, field: Field, element: Any) -> None:
        written = self.draft.tree_value(field.key)
        value = written if written is not None else (None if field.optional else self.draft.value(field.key))
        if field.kind == "switch":
            element.value = bool(value)
        elif field.kind == "choice":
            element.value = value if value in field.choices else ("" if field.optional else None)
        else:
            element.value = shown_value(field.key, value)


def _choice_in_words(choice: str | bool) -> str:
    return choice.replace("_", " ") if isinstance(choice, str) else "on" if choice else "off"
