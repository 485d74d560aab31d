"""The scene: its sections, which must agree with each other; and scenes from files, with keys overridden and the paths
of their files made absolute.

What computes is imported where it is asked: it takes a second to load, and who only wants the keys does without.
"""

from __future__ import annotations

import math
import os
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from annotated_types import Ge, Le
from pydantic import AfterValidator, BeforeValidator, model_validator

from ..conventions import ground_range, radar_wavelength
from ..errors import InputError, must_be
from ..io import scenefile
from ..io.text import TableMixin, number_text
from ..io.validation import Key, validate, without
from ..settings import (
    GaugeSettings,
    Meaning,
    ObjectSettings,
    PlatformSettings,
    PredictionSettings,
    RadarSettings,
    RetrievalSettings,
    ScatteringSettings,
    SeaSettings,
    Section,
    TracingSettings,
    as_tuple,
    meaning_of,
)

if TYPE_CHECKING:
    from ..mesh.sizing import MeshDetail

_NAME = r"[A-Za-z0-9][A-Za-z0-9._+-]{0,99}"


_MOST_WAVES = 4  # systems that a scene's short form shows
_OF_WAVES = "significant_wave_height_m", "height_m", "peak_period_s", "wavelength_m", "wind_speed_m_s", "wave_from_deg"


def _in_words(section: Section, *keys: str) -> str:
    """Keys with values and units, but for those that it has not or are left out."""
    words: list[str] = []
    for key in keys:
        value, field = getattr(section, key, None), type(section).model_fields.get(key)
        if value is None or field is None:
            continue
        unit = meaning_of(field).unit
        numbers = value if isinstance(value, tuple) else (value,)
        text = "–".join(each if isinstance(each, str) else number_text(each) for each in numbers)
        name = re.sub(r"_(m_s|m|s|hz|w|deg|rpm)$", "", key).replace("_", " ")
        words.append(f"{name} {text}" + ("" if unit in (None, "1") else unit if unit == "°" else f" {unit}"))
    return ", ".join(words)


def is_name(name: str) -> bool:
    """Whether a scene may be called so."""
    return re.fullmatch(_NAME, name) is not None


def _file_name(name: str) -> str:
    if not is_name(name):
        raise ValueError(
            "must be 1 to 100 letters, digits and . _ + -, the first a letter or digit (it names the results' folder)"
        )
    return name


class Scene(TableMixin, Section):
    """All that a run depends on."""

    name: Annotated[str, AfterValidator(_file_name), Meaning(pattern=f"^{_NAME}$")]
    """Name of the scene and of its results' folder."""
    title: str = ""
    """What the scene shows, in a line."""
    seed: Annotated[int, Ge(0), Meaning("1", "seeds of the random source count from 0")] = 1
    """Seed of all random numbers: the same seed gives the same bits."""
    turns: Annotated[int, Ge(1), Le(1_000_000), Meaning("1", "turns of the antenna")] = 1
    """Turns of the antenna, the sea running on; or maps of a staring one."""
    earth: Literal["flat"] = "flat"
    """Shape of the earth."""
    sea: SeaSettings = SeaSettings()
    """The water and its waves."""
    scattering: ScatteringSettings = ScatteringSettings()
    """Wind and echo | How the sea returns the radar's power."""
    radar: RadarSettings = RadarSettings()
    """The radar."""
    platform: PlatformSettings = PlatformSettings()
    """Boat | The boat that carries it."""
    objects: Annotated[tuple[ObjectSettings, ...], BeforeValidator(as_tuple)] = ()
    """Things in the scene, `[[objects]]`."""
    gauges: Annotated[tuple[GaugeSettings, ...], BeforeValidator(as_tuple)] = ()
    """Wave gauges | Virtual wave gauges, `[[gauges]]`."""
    tracing: TracingSettings = TracingSettings()
    """Shadows and mesh | Light and shadow, and the mesh."""
    retrieval: RetrievalSettings = RetrievalSettings()
    """How echoes become maps."""
    prediction: PredictionSettings = PredictionSettings()
    """Forecast | How maps become forecasts."""

    @property
    def detail(self) -> MeshDetail:
        """How fine the mesh is made."""
        from ..mesh.sizing import mesh_detail

        return mesh_detail(self.sea, self.radar, self.tracing, self.scattering)

    @property
    def resolved_retrieval(self) -> RetrievalSettings:
        """The retrieval with the sea's depth and current where it names none: an operator has them from a chart; and
        with the error of the angle of arrival, where the scene's light bends.

        Deep water at rest is what the retrieval assumes by itself: then it stays as it is, and makes of the echoes on
        file what it makes of them in a run.
        """
        known: dict[str, float] = {}
        if not (math.isinf(self.sea.depth_m) and self.sea.current_m_s == 0.0):
            known = {name: getattr(self.sea, name) for name in ("depth_m", "current_m_s", "current_toward_deg")}
        if self.tracing.diffraction != "none":
            from ..physics.shadowing import arrival_error_mrad

            known["diffraction_mrad"] = arrival_error_mrad("VV", self.wavelength_m)  # as knife edges do in either
        known = {name: value for name, value in known.items() if getattr(self.retrieval, name) is None}
        return self.retrieval.model_copy(update=known) if known else self.retrieval

    @property
    def resolved_prediction(self) -> PredictionSettings:
        """The prediction with the boat's own course where it names none."""
        names = ("heading_deg", "speed_m_s")
        known = {name: getattr(self.platform, name) for name in names if getattr(self.prediction, name) is None}
        return self.prediction.model_copy(update=known)

    @property
    def meshing(self) -> TracingSettings:
        """The tracing with the mesh's spacings filled in."""
        return self.detail.meshing(self.tracing)

    @property
    def wavelength_m(self) -> float:
        """The radar's wavelength."""
        return radar_wavelength(self.radar.frequency_hz)

    @property
    def turn_duration_s(self) -> float:
        """How long one turn of the antenna lasts."""
        from ..radar.scan import turn_duration

        return turn_duration(self.radar)

    @property
    def far_ground_range(self) -> float:
        """Horizontal distance [m] at which the far end of the range window meets mean sea level."""
        return float(ground_range(self.radar.range_m[1], self.radar.height_m))

    def to_toml(self) -> str:
        """The scene file with every key resolved: it reads back to an equal scene."""
        return scenefile.tree_to_toml(self.model_dump())

    def rows(self) -> list[tuple[str, str]]:
        """The keys that one asks for first, by section."""
        return [
            ("scene", f"{self.name}: {self.title}" if self.title else self.name),
            ("sea", _in_words(self.sea, "model", "extent_m", "resolution_m", "energy_fraction", "depth_m")),
            *(("waves", _in_words(each, "spectrum", *_OF_WAVES)) for each in self.sea.waves[:_MOST_WAVES]),
            ("radar", _in_words(self.radar, "frequency_hz", "waveform", "pulse_width_s", "transmit_power_w", "prf_hz")),
            ("antennas", _in_words(self.radar, "height_m", "baseline_m", "tilt_deg", "transmit")),
            ("scan", _in_words(self.radar, "scan", "range_m", "sector_deg", "rotation_rpm")),
            ("platform", _in_words(self.platform, "motion", "speed_m_s", "heading_deg")),
            ("retrieval", _in_words(self.retrieval, "estimator", "cell_range_m", "cell_azimuth_deg", "window_range_m")),
            ("run", f"{_in_words(self, 'turns', 'seed')}, {_in_words(self.tracing, 'tracer')}; all keys: .to_toml()"),
        ]

    @model_validator(mode="after")
    def _check_sections(self) -> Self:
        from .agreement import disagreements

        if problems := disagreements(self):
            raise InputError(*problems)
        return self


# ------------------------------------------------------------------------------------------------- from files


SceneLike = Scene | str | os.PathLike[str]  # a scene, the path of its file, or a shipped one's name


def load_scene(path_or_name: str | os.PathLike[str], overrides: Mapping[str, Any] | None = None) -> Scene:
    """The scene of a file, or a shipped one by its name, with keys overridden.

    path_or_name: "mine.toml" or "choppy_sea". overrides: as {"radar.height_m": 10.0}.

    Files that a scene names count from the scene file's folder, those of overrides from the working folder. Raises
    InputError with whatever is wrong with the file or the scene: its `problems`, and its message, have a line for each.
    """
    if overrides is not None:
        must_be("overrides", overrides, Mapping, 'a dict of keys, such as {"radar.height_m": 10.0}')
    path = scenefile.find_scene(path_or_name)
    return _overridden(anchored(scenefile.read_toml(path), path.parent), overrides or {})


def with_keys(scene: Scene, overrides: Mapping[str, Any]) -> Scene:
    """The scene with keys overridden, as `load_scene` overrides those of its file; raises as it does."""
    return _overridden(tomllib.loads(scene.to_toml()), overrides)


def _overridden(tree: dict[str, Any], overrides: Mapping[str, Any]) -> Scene:
    for key, other in (("energy_fraction", "resolution_m"), ("resolution_m", "energy_fraction")):
        # Either sets the resolution: the one that is overridden takes the other's place in the file.
        replaces = overrides.get(f"sea.{key}") is not None and f"sea.{other}" not in overrides
        if replaces and isinstance(tree.get("sea"), dict):
            tree["sea"].pop(other, None)
    tree = anchored(scenefile.apply_overrides(tree, overrides), Path.cwd())
    return scene_of(tree)


def scene_of(tree: Mapping[str, Any]) -> Scene:
    """The scene of a tree whose paths are absolute (`anchored`). InputError as `load_scene` raises it."""
    return validate(Scene, _fill_recorded(tree), _find_disagreements)


def _fill_recorded(tree: Mapping[str, Any]) -> Mapping[str, Any]:
    """The tree with the keys of a recorded sea that it leaves out, by the sea's file."""
    sea = tree.get("sea")
    if not isinstance(sea, Mapping) or sea.get("model") != "recorded":
        return tree
    if not isinstance(sea.get("file"), str) or not sea["file"]:
        return tree
    from ..io.recorded_sea import recorded_sea

    file = recorded_sea(sea["file"])
    known: dict[str, Any] = {
        "extent_m": max(round(2.0 * file.reach_m, 3), 10.0),
        "waves": [{"spectrum": "file", "kind": "recorded", "file": sea["file"]}],
    }
    if sea.get("energy_fraction") is None:
        known["resolution_m"] = file.spacing_m
    if file.depth_m is not None:
        known["depth_m"] = file.depth_m
    given = {name: value for name, value in sea.items() if name != "waves" or value}  # none is left out
    return {**tree, "sea": {**known, **given}}


def _find_disagreements(tree: Mapping[str, Any], wrong: frozenset[Key]) -> list[str]:
    """What is wrong between the sections of a scene with wrong keys, as far as it can be found without them."""
    from .agreement import disagreements  # loads what computes

    return disagreements(without(Scene, tree, wrong), whole=False)


def as_scene(scene: SceneLike) -> Scene:
    """A scene as it is, or that of a file or of a shipped scene's name. Raises InputError as `load_scene` does."""
    if isinstance(scene, Scene):
        return scene
    must_be("scene", scene, (str, os.PathLike), "a Scene, the name of a shipped one, or the path of a scene file")
    return load_scene(scene)


def anchored(tree: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The tree with the paths of its files (`file`, `mesh`) made absolute, so that it means the same everywhere."""
    for key, value in tree.items():
        for table in value if isinstance(value, list | tuple) else [value]:
            if isinstance(table, dict):
                anchored(table, folder)
        if key in ("file", "mesh") and isinstance(value, str) and value and "\0" not in value:  # that is refused later
            tree[key] = str((folder / value).resolve())
    return tree
