"""Keys of a scene in words: what a reader of a study calls them, with their units."""

from __future__ import annotations

from typing import Any, NamedTuple, get_args

from pydantic import BaseModel

from ..scene import Scene
from ..settings import Meaning

_NAMES = {
    "radar.height_m": "antenna height",
    "radar.baseline_m": "baseline",
    "radar.transmit_power_w": "transmit power",
    "radar.frequency_hz": "frequency",
    "radar.bandwidth_hz": "bandwidth",
    "radar.transmit": "mode",
    "radar.polarization": "polarization",
    "sea.depth_m": "depth",
    "tracing.tracer": "tracer",
}
_LEAVES = {
    "significant_wave_height_m": "significant wave height",
    "peak_period_s": "peak period",
    "wind_speed_m_s": "wind speed",
    "wave_from_deg": "direction from which the waves come",
}
_UNIT_ENDINGS = ("_m_s", "_dbsm", "_dbm", "_deg", "_hz", "_db", "_m", "_s", "_w")


class KeyWords(NamedTuple):
    """name: lower case; unit: empty where there is none; meaning: a sentence, empty where the schema has none."""

    name: str
    unit: str
    meaning: str

    @property
    def label(self) -> str:
        """For an axis or the head of a column."""
        return f"{self.name[0].upper()}{self.name[1:]}" + (f" ({self.unit})" if self.unit else "")

    def value(self, value: Any) -> str:
        """A value with its unit."""
        text = f"{value:g}" if _is_number(value) else str(value)
        return f"{text} {self.unit}" if self.unit and _is_number(value) else text


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def words_of(key: str) -> KeyWords:
    """Of any key of a scene, as `radar.height_m` or `sea.waves.0.hs_m`."""
    meaning, leaf = _meaning(Scene, key.split(".")), key.rsplit(".", 1)[-1]
    unit = meaning.unit if meaning is not None and meaning.unit not in (None, "1") else ""
    return KeyWords(_NAMES.get(key) or _LEAVES.get(leaf) or _plain(key), unit or "", meaning.text if meaning else "")


def _plain(key: str) -> str:
    *sections, leaf = (part for part in key.split(".") if not part.isdigit())
    ending = next((each for each in _UNIT_ENDINGS if leaf.endswith(each)), "")
    return " ".join([*sections[-1:], leaf.removesuffix(ending)]).replace("_", " ")


def _meaning(model: type[BaseModel], path: list[str]) -> Meaning | None:
    """What the schema says of a key; a list's number is passed over, of a union the first that has the key."""
    name, *rest = path
    if name.isdigit():
        return _meaning(model, rest) if rest else None
    field = model.model_fields.get(name)
    if field is None:
        return None
    if not rest:
        return next((each for each in field.metadata if isinstance(each, Meaning)), None)
    return next((found for each in _models(field.annotation) if (found := _meaning(each, rest)) is not None), None)


def _models(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for part in get_args(annotation) for model in _models(part)]
