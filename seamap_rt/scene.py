"""A scene: every section of one run, validated together.

Checks across sections live here; each refusal gives key, value, limit, reason and remedy in one sentence.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, model_validator

from .conventions import SPEED_OF_LIGHT
from .io import scenefile
from .mesh.sizing import MOST_TRIANGLES, MeshDetail, mesh_detail, triangles
from .radar.array import antenna_array
from .radar.checks import check_radar, pulses_of_a_look, pulses_of_a_turn
from .radar.platform import boat_motion
from .radar.scan import BEAMS_BEYOND, sector_width, turn_duration
from .radar.waveform import RangeResponse, gate_spacing_m
from .scattering import MEAN_MODELS, PERMITTIVITIES, sea_state_from_wind, wind_from_sea_state
from .settings import (
    AntennaSettings,
    GaugeSettings,
    ObjectSettings,
    PlatformSettings,
    RadarSettings,
    RandomWaves,
    RetrievalSettings,
    ScatteringSettings,
    SeaSettings,
    Section,
    SinusoidWaves,
    TracingSettings,
    as_tuple,
    limited,
)

LEAST_MARGIN_M = 30.0  # beyond the far gate; the mesh itself runs on by the range response's reach
BYTES_PER_VOLTAGE = 32.0  # the voltage itself, its noise and the sums it is made from
MOST_ECHO_BYTES = 8e9
MOST_GROUND_CELLS = 1e7
BYTES_PER_TRIANGLE = 600.0  # vertices, the tracer's tree and the facets' arrays
LEAST_WIND = 0.5  # m/s, of scattering.wind_speed_m_s
STEEPEST = math.sin(math.radians(59.9))  # sine of the grazing angle beyond which no clutter model is asked
HALF_POWER = 0.442947  # sinc² is ½ there: half a uniform aperture's beam, as (aperture/λ) · direction cosine


def _file_name(name: str) -> str:
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9._+-]{0,99}", name):
        raise ValueError(
            "must be 1 to 100 letters, digits and . _ + -, the first a letter or digit (it names the results' folder)"
        )
    return name


class Scene(Section):
    """All that a run depends on."""

    name: Annotated[str, AfterValidator(_file_name)]
    title: str = ""
    seed: Annotated[int, limited("seeds of the random source count from 0", least=0)] = 1
    turns: Annotated[int, limited("turns of the antenna", least=1, most=1_000_000)] = 1
    earth: Literal["flat"] = "flat"
    sea: SeaSettings = SeaSettings()
    scattering: ScatteringSettings = ScatteringSettings()
    radar: RadarSettings = RadarSettings()
    platform: PlatformSettings = PlatformSettings()
    objects: Annotated[tuple[ObjectSettings, ...], BeforeValidator(as_tuple)] = ()
    gauges: Annotated[tuple[GaugeSettings, ...], BeforeValidator(as_tuple)] = ()
    tracing: TracingSettings = TracingSettings()
    retrieval: RetrievalSettings = RetrievalSettings()

    @property
    def detail(self) -> MeshDetail:
        """How fine the mesh is made."""
        return mesh_detail(self.sea, self.radar, self.tracing, self.scattering)

    @property
    def meshing(self) -> TracingSettings:
        """The tracing with the mesh's spacings filled in."""
        return self.detail.meshing(self.tracing)

    @property
    def wavelength_m(self) -> float:
        """The radar's wavelength."""
        return SPEED_OF_LIGHT / self.radar.frequency_hz

    @property
    def turn_duration_s(self) -> float:
        """How long one turn of the antenna lasts."""
        return turn_duration(self.radar)

    @property
    def far_ground_range(self) -> float:
        """Horizontal distance [m] at which the far end of the range window meets mean sea level."""
        return math.sqrt(self.radar.range_m[1] ** 2 - self.radar.height_m**2)

    def to_toml(self) -> str:
        """The scene file with every key resolved: it reads back to an equal scene."""
        return scenefile.to_toml(self)

    # The checks run in this order; a limit that they name passes when typed in.

    @model_validator(mode="after")
    def _beam_is_not_narrower_than_the_aperture_allows(self) -> Self:
        for key, antenna in (
            ("radar.antenna", self.radar.antenna),
            *((f"radar.antennas.{number}", placed) for number, placed in enumerate(self.radar.antennas)),
        ):
            if antenna.pattern == "slotted_waveguide":
                self._aperture_is_wide_enough(key, antenna)
        return self

    def _aperture_is_wide_enough(self, key: str, antenna: AntennaSettings) -> None:
        for beam_key, beam_deg, aperture_key, aperture in (
            ("azimuth_beamwidth_deg", antenna.azimuth_beamwidth_deg, "width_m", antenna.width_m),
            ("elevation_beamwidth_deg", antenna.elevation_beamwidth_deg, "height_m", antenna.height_m),
        ):
            # 0.886 λ/aperture in its exact form, which holds for small apertures too.
            needed = HALF_POWER * self.wavelength_m / math.sin(math.radians(0.5 * beam_deg))
            if aperture < needed:
                cosine = HALF_POWER * self.wavelength_m / aperture
                narrowest = 2.0 * math.degrees(math.asin(min(1.0, cosine)))
                raise ValueError(
                    f"{key}.{beam_key} = {beam_deg:.10g}: must be at least {_up(narrowest)} (the "
                    f"beam of a uniform aperture of {key}.{aperture_key} = {aperture:.10g}, and a "
                    f"taper only widens it); widen the beam, or raise {key}.{aperture_key} to "
                    f"{_up(needed)}"
                )

    @model_validator(mode="after")
    def _the_radar_can_work(self) -> Self:
        check_radar(self.radar)
        receivers = len(antenna_array(self.radar).receivers)
        first, second = chosen = self.retrieval.receivers
        if first == second or not all(0 <= number < receivers for number in chosen):
            raise ValueError(
                f"retrieval.receivers = [{first}, {second}]: must be two different ones of the {receivers} receivers, "
                f"which are numbered from 0 to {receivers - 1}"
            )
        return self

    @model_validator(mode="after")
    def _the_boat_is_known(self) -> Self:
        if self.platform.motion == "file":
            # Reads the file, says what is wrong with it, and whether it is as long as the run, with what a turn hears
            # before and after itself and what sensors ask for earlier.
            sensors, beam = self.platform.sensors, antenna_array(self.radar).beam_deg
            beside = min(360.0, (BEAMS_BEYOND + 1.0) * beam + 5.0) / (6.0 * self.radar.rotation_rpm)
            reading = 0.0 if math.isinf(sensors.rate_hz) else 1.0 / sensors.rate_hz
            early, late = min(-beside, -sensors.latency_s - reading), max(beside, reading)
            boat_motion(self.platform)([0.0, early, self.turns * self.turn_duration_s + late])
        for number, thing in enumerate(self.objects):
            if not Path(thing.mesh).is_file():
                raise ValueError(f"objects.{number}.mesh = '{thing.mesh}': no such file; give the path of a mesh")
        return self

    @model_validator(mode="after")
    def _sea_is_in_the_range_window(self) -> Self:
        (near, far), height = self.radar.range_m, self.radar.height_m
        if far <= height:
            raise ValueError(
                f"radar.range_m = [{near:.10g}, {far:.10g}]: its far end must be greater than radar.height_m "
                f"= {height:.10g} (the sea lies farther below the antenna, so nothing is seen); raise the "
                "far end or lower radar.height_m"
            )
        return self

    @model_validator(mode="after")
    def _antennas_are_above_water(self) -> Self:
        height, baseline = self.radar.height_m, self.radar.baseline_m
        tilt = math.radians(self.radar.tilt_deg)
        offsets = antenna_array(self.radar).known_offsets
        reach = -min(up * math.cos(tilt) - ahead * math.sin(tilt) for _, ahead, up in offsets)
        if height <= reach:
            lowest = "the lowest of radar.antennas" if self.radar.antennas else "the lower phase centre"
            far = (
                f"half of radar.baseline_m = {baseline:.10g} further down"
                if not self.radar.antennas
                else "by its offset"
            )
            raise ValueError(
                f"radar.height_m = {height:.10g}: must be greater than {_up(reach)} ({lowest}, {far}, would be under "
                "water); raise radar.height_m or "
                + ("move it up" if self.radar.antennas else "shorten radar.baseline_m")
            )
        return self

    @model_validator(mode="after")
    def _range_circle_fits_the_patch(self) -> Self:
        margin = max(LEAST_MARGIN_M, RangeResponse.of(self.radar).support_m)
        needed, extent = 2.0 * (self.radar.range_m[1] + margin), self.sea.extent_m
        repeats = any(
            isinstance(waves, RandomWaves) and getattr(waves, "spreading", None) != "long_crested"
            for waves in self.sea.waves
        )
        if repeats and extent < needed:
            room = 0.5 * extent - margin
            nearer = f" or lower the far end of radar.range_m to {_down(room)}" if room > 0.0 else ""
            raise ValueError(
                f"sea.extent_m = {extent:.10g}: must be at least {_up(needed)} (the range circle, 2 × (far "
                f"end of radar.range_m + {margin:.10g} m), must fit in the periodic patch, or the same "
                f"waves are seen twice); raise sea.extent_m{nearer}"
            )
        return self

    @model_validator(mode="after")
    def _gates_are_close_enough(self) -> Self:
        sampling, cell = self.radar.range_sampling_m, self.retrieval.cell_range_m
        if sampling > cell:
            raise ValueError(
                f"radar.range_sampling_m = {sampling:.10g}: must be at most retrieval.cell_range_m = "
                f"{cell:.10g} (else cells hold no gate); lower radar.range_sampling_m or lengthen "
                "retrieval.cell_range_m"
            )
        chirp = self.radar.waveform == "chirp"
        swept = self.radar.chirp_bandwidth_hz if chirp else 1.0 / self.radar.pulse_width_s
        resolution = SPEED_OF_LIGHT / (2.0 * min(self.radar.bandwidth_hz, swept))
        if gate_spacing_m(self.radar) > resolution:
            raise ValueError(
                f"radar.range_sampling_m = {sampling:.10g}: must be at most the range resolution of "
                f"{_down(resolution)} m (c/2 over the lesser of radar.bandwidth_hz and "
                f"{'radar.chirp_bandwidth_hz' if chirp else '1/radar.pulse_width_s'}; the sea between the gates "
                f"would be missed); lower radar.range_sampling_m to {_down(resolution)}"
            )
        return self

    @model_validator(mode="after")
    def _looks_hold_pulses(self) -> Self:
        prf, rpm, least = self.radar.prf_hz, self.radar.rotation_rpm, 2.0
        array = antenna_array(self.radar)
        if not array.whole:
            least = 2.0 * len(array.cycle)  # each receiver twice
        cell, sector = self.retrieval.cell_azimuth_deg, sector_width(self.radar)
        if cell > sector + 1e-9:
            raise ValueError(
                f"retrieval.cell_azimuth_deg = {cell:.10g}: must be at most {_down(sector)} "
                "(radar.sector_deg holds not one whole look); narrow retrieval.cell_azimuth_deg or widen "
                "radar.sector_deg"
            )
        pulses = pulses_of_a_look(self.radar, cell)
        if pulses < least - 1e-9 and self.radar.scan == "staring":
            raise ValueError(
                f"radar.stare_s = {self.radar.stare_s:.10g}: must be at least {_up(least / prf)} (it holds "
                f"{pulses:.3g} pulses and needs {least:g}); lengthen it or raise radar.prf_hz to "
                f"{_up(least * prf / pulses)}"
            )
        if pulses < least - 1e-9:
            raise ValueError(
                f"retrieval.cell_azimuth_deg = {cell:.10g}: must be at least {_up(least * cell / pulses)} (a "
                f"look holds {pulses:.3g} pulses and needs {least:g}); widen retrieval.cell_azimuth_deg, raise "
                f"radar.prf_hz to {_up(least * prf / pulses)} or slow radar.rotation_rpm to "
                f"{_down(rpm * pulses / least)}"
            )
        return self

    @model_validator(mode="after")
    def _window_holds_a_cell(self) -> Self:
        (near, far), cell = self.radar.range_m, self.retrieval.cell_range_m
        length = max(cell, 2.0 * gate_spacing_m(self.radar))
        if far - near < length:
            raise ValueError(
                f"radar.range_m = [{near:.10g}, {far:.10g}]: must be at least {length:.4g} long (a cell of "
                "retrieval.cell_range_m, or three gates); raise its far end"
            )
        return self

    @model_validator(mode="after")
    def _a_turn_of_echoes_fits_memory(self) -> Self:
        near, far = self.radar.range_m
        pulses = pulses_of_a_turn(self.radar)
        gates = (far - near) / self._sample_spacing + 1.0
        needed = BYTES_PER_VOLTAGE * len(antenna_array(self.radar).receivers) * pulses * gates
        if needed > MOST_ECHO_BYTES:
            raise ValueError(
                f"radar.prf_hz = {self.radar.prf_hz:.10g}: a turn would hold {pulses:.3g} pulses of {gates:.3g} gates "
                f"and take {needed / 1e9:.3g} GB, and may take {MOST_ECHO_BYTES / 1e9:.3g}; lower radar.prf_hz, raise "
                "radar.rotation_rpm or radar.range_sampling_m, narrow radar.sector_deg or shorten radar.range_m"
            )
        return self

    @property
    def _sample_spacing(self) -> float:
        """Of what the receiver samples [m]."""
        if self.radar.receiver.chain == "digital":
            return SPEED_OF_LIGHT / (2.0 * self.radar.receiver.adc_rate_hz)
        return self.radar.range_sampling_m

    @model_validator(mode="after")
    def _ground_map_fits_memory(self) -> Self:
        far, side = self.radar.range_m[1], self.retrieval.ground_m
        cells = (2.0 * far / side) ** 2
        if cells > MOST_GROUND_CELLS:
            least = 2.0 * far / math.sqrt(MOST_GROUND_CELLS)
            raise ValueError(
                f"retrieval.ground_m = {side:.10g}: must be at least {_up(least)} (the ground map would have "
                f"{cells:.3g} cells, and may have {MOST_GROUND_CELLS:.3g}); raise retrieval.ground_m"
            )
        return self

    @model_validator(mode="after")
    def _the_permittivity_model_holds(self) -> Self:
        water = self.scattering
        try:
            PERMITTIVITIES[water.permittivity](self.radar.frequency_hz, water.temperature_c, water.salinity_psu)
        except ValueError as error:
            raise ValueError(
                f"scattering.permittivity = '{water.permittivity}': {error}, or choose another scattering.permittivity"
            ) from None
        return self

    @model_validator(mode="after")
    def _the_mean_model_holds(self) -> Self:
        name = self.scattering.mean_model
        if name is None or self.scattering.extrapolate:
            return self
        model = MEAN_MODELS[name]
        key = "scattering.nrcs" if self.scattering.nrcs == name else "scattering.calibrated_to"
        other = f"or choose another {key}" + (" ('none' leaves theory alone)" if key.endswith("to") else "")
        remedy = f"{other}, or set scattering.extrapolate = true to let its formula run on"
        least, most = model.sea_state
        wind = self.scattering.wind_speed_m_s
        if not least <= sea_state_from_wind(wind) <= most:
            limits = [max(LEAST_WIND, float(wind_from_sea_state(state))) for state in (least, most)]
            raise ValueError(
                f"scattering.wind_speed_m_s = {wind:.10g}: must be {_up(limits[0])} to {_down(limits[1])} (sea state "
                f"{least:g} to {most:g}, where {key} = '{name}' holds: {model.paper}); change it, {remedy}"
            )
        low, high = model.frequency_hz
        frequency = self.radar.frequency_hz
        if not low <= frequency <= high:
            raise ValueError(
                f"radar.frequency_hz = {frequency:.10g}: must be {low:g} to {high:g}, where {key} = '{name}' holds "
                f"({model.paper}); change it, {remedy}"
            )
        if name != "nrl":
            self._grazing_is_within(key, name, f"{other}, or set scattering.extrapolate = true to keep its edge value")
        return self

    def _grazing_is_within(self, key: str, name: str, remedy: str) -> None:
        """NRL 2012 reaches from 0.1° to 60°, and what little lies beyond takes its edge value; the others end sooner.
        Steeper than 60°, about the mast's foot, no clutter model is asked."""
        (near, far), height = self.radar.range_m, self.radar.height_m
        model = MEAN_MODELS[name]
        least, most = (math.sin(math.radians(angle)) for angle in model.grazing_deg)
        if far > height / least:
            raise ValueError(
                f"radar.range_m = [{near:.10g}, {far:.10g}]: its far end must be at most {_down(height / least)} "
                f"(there the sea is seen under {model.grazing_deg[0]:g}°, the least for which {key} = '{name}' holds: "
                f"{model.paper}); lower it, {remedy}"
            )
        if near < height / most and most < STEEPEST:
            if far <= height / most:
                raise ValueError(
                    f"radar.range_m = [{near:.10g}, {far:.10g}]: lies wholly nearer than {_up(height / most)} (there "
                    f"the sea is seen under {model.grazing_deg[1]:g}°, the most for which {key} = '{name}' holds: "
                    f"{model.paper}); move it out, lower radar.height_m, {remedy}"
                )
            raise ValueError(
                f"radar.range_m = [{near:.10g}, {far:.10g}]: its near end must be at least {_up(height / most)} (there "
                f"the sea is seen under {model.grazing_deg[1]:g}°, the most for which {key} = '{name}' holds: "
                f"{model.paper}); raise it, {remedy}"
            )

    @model_validator(mode="after")
    def _facets_follow_the_waves(self) -> Self:
        facet = self.detail.facet_m
        for number, waves in enumerate(self.sea.waves):
            if isinstance(waves, SinusoidWaves) and waves.height_m > 0.0 and waves.wavelength_m < 4.0 * facet:
                raise ValueError(
                    f"tracing.facet_m = {facet:.10g}: must be at most {_down(0.25 * waves.wavelength_m)} (a quarter of "
                    f"sea.waves.{number}.wavelength_m = {waves.wavelength_m:.10g}, or the mesh misses the wave); lower "
                    "tracing.facet_m or lengthen the wave"
                )
        return self

    @model_validator(mode="after")
    def _mesh_fits_memory(self) -> Self:
        facet, columns = self.detail.facet_m, self.detail.columns_per_beam
        count = float(triangles(self.radar, facet, columns))
        if count > MOST_TRIANGLES:
            raise ValueError(
                f"tracing.facet_m = {facet:.10g}: must be at least {_up(facet * count / MOST_TRIANGLES)} "
                f"for this sector and range (the mesh would have {count:.3g} triangles, "
                f"{_gigabytes(count)}, and may have {MOST_TRIANGLES:.3g}, {_gigabytes(MOST_TRIANGLES)}); "
                "raise tracing.facet_m, lower tracing.columns_per_beam, narrow radar.sector_deg or shorten "
                "radar.range_m"
            )
        return self

    @model_validator(mode="after")
    def _gauges_tell_each_other_apart(self) -> Self:
        names = [gauge.name for gauge in self.gauges]
        for number, gauge in enumerate(self.gauges):
            first = names.index(gauge.name)
            if first < number:
                raise ValueError(
                    f"gauges.{number}.name = '{gauge.name}': is the name of gauges.{first}; give each gauge its own"
                )
            rate = self.gauges[0].sample_hz
            if gauge.sample_hz != rate:
                raise ValueError(
                    f"gauges.{number}.sample_hz = {gauge.sample_hz:.10g}: must be {rate:.10g}, that of gauges.0 (all "
                    "gauges are read together); give them one rate"
                )
        return self

    @model_validator(mode="after")
    def _gauges_stand_where_the_radar_looks(self) -> Self:
        moves = self.platform.speed_m_s > 0.0 or self.platform.motion == "file"
        near = 0.0 if moves else math.sqrt(max(0.0, self.radar.range_m[0] ** 2 - self.radar.height_m**2))
        far = self.far_ground_range
        start, stop = self.radar.sector_deg
        if self.radar.scan == "staring":
            middle, half = 0.5 * (start + stop), 0.5 * self.retrieval.cell_azimuth_deg
            start, stop = middle - half, middle + half
        for number, gauge in enumerate(self.gauges):
            about, (east, north) = f"gauges.{number}: '{gauge.name}' stands", gauge.place
            away, azimuth = math.hypot(east, north), math.degrees(math.atan2(east, north)) % 360.0
            if not near * (1.0 - 1e-9) <= away <= far:
                raise ValueError(
                    f"{about} {away:.4g} m from the antenna, and must stand {_up(near)} to {_down(far)} m from it "
                    "(radar.range_m over the water); move it or change radar.range_m"
                )
            if not moves and (azimuth - start + 1e-9) % 360.0 > stop - start + 2e-9:
                looks = "the one look of radar.sector_deg" if self.radar.scan == "staring" else "radar.sector_deg"
                raise ValueError(
                    f"{about} at azimuth {azimuth:.4g}°, outside of {looks} ({start:.10g}° to {stop:.10g}°); move it "
                    "or change radar.sector_deg"
                )
        return self


def load_scene(path_or_name: str | os.PathLike[str], overrides: Mapping[str, Any] | None = None) -> Scene:
    """The scene of a file, or a shipped one by its name, with keys overridden as {"radar.height_m": 10.0}.

    Spectrum files count from the scene file's folder, those of overrides from the working folder.
    """
    path, overrides = scenefile.find_scene(path_or_name), overrides or {}
    tree = _anchored(scenefile.read_toml(path), path.parent)
    for key, other in (("energy_fraction", "resolution_m"), ("resolution_m", "energy_fraction")):
        # Either says the same thing: one that is asked for takes the other's place in the file.
        asked = overrides.get(f"sea.{key}") is not None and f"sea.{other}" not in overrides
        if asked and isinstance(tree.get("sea"), dict):
            tree["sea"].pop(other, None)
    return scenefile.validate(Scene, _anchored(scenefile.apply_overrides(tree, overrides), Path.cwd()))


def _anchored(tree: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The tree with the paths of its files made absolute, so that the scene means the same everywhere."""
    radar = _table(tree.get("radar"))
    holders = [("file", each) for each in _tables(_table(tree.get("sea")).get("waves"))]
    holders += [("file", _table(tree.get("platform"))), ("file", _table(radar.get("antenna")))]
    holders += [("file", each) for each in _tables(radar.get("antennas"))]
    holders += [("mesh", each) for each in _tables(tree.get("objects"))]
    for key, holder in holders:
        if isinstance(holder.get(key), str) and holder[key]:
            holder[key] = str((folder / holder[key]).resolve())
    return tree


def _table(value: Any) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}


def _tables(value: Any) -> list[dict[str, Any]]:
    return [_table(entry) for entry in value] if isinstance(value, list | tuple) else []


def _up(value: float) -> str:
    """Four digits, rounded up: a limit that satisfies its check when it is typed in."""
    return _four_digits(value, math.ceil)


def _down(value: float) -> str:
    return _four_digits(value, math.floor)


def _four_digits(value: float, towards: Callable[[float], int]) -> str:
    if value == 0.0:
        return "0"
    scale = 10.0 ** (3 - math.floor(math.log10(abs(value))))
    return f"{towards(value * scale) / scale:.6g}"


def _gigabytes(triangles: float) -> str:
    return f"{triangles * BYTES_PER_TRIANGLE / 1e9:.3g} GB"
