"""Writing the products: fields stream into the file time by time, then the statistics, then the pictures."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.image import imsave

from ..dataset import build
from ..errors import InputError, NoBackendError, report_partial_results
from ..io.appendable import AppendableNetCDF
from ..io.process import Progress, ignore_progress
from ..io.results_folder import clear_folder, note_growing, results_folder, write_whole
from ..physics import dispersion
from ..report import reduce, sea_figures, spectrum_figures, style
from ..scattering import ShortWaves
from ..scene import Scene
from ..sea import Sea, directional_density, spectral_system, wave_facts
from ..settings import RandomWaves
from ..simulation import Simulator
from ..tracing import tracer
from .camera import Camera
from .sampling import point_spacing, refuse_too_large, square_points, times_of
from .statistics import Moments, requested_height, statistics_table

SHORT_CRESTED, LONG_CRESTED, REGULAR = 0, 1, 2  # kinds of wave systems
_DIRECTIONS, _FREQUENCIES = 180, 240


def directional_spectrum(scene: Scene, sea: Sea) -> xr.Dataset:
    """The schema's `sea/spectrum`: what is expected of the scene's wave systems, those too that are not resolved."""
    depth = scene.sea.depth_m
    every = ((number, waves, wave_facts(waves, depth)) for number, waves in enumerate(scene.sea.waves))
    known = [(number, waves, facts) for number, waves, facts in every if facts is not None]
    limit = float(dispersion.angular_frequency(sea.resolved.wavenumber_limit, depth)) / (2.0 * np.pi)
    peaks = [1.0 / facts.peak_period for _, _, facts in known]
    lowest, highest = 0.3 * min([*peaks, limit]), max([1.5 * limit, *(6.0 * peak for peak in peaks)])
    frequency = np.geomspace(lowest, highest, _FREQUENCIES)
    direction = 360.0 / _DIRECTIONS * np.arange(_DIRECTIONS)
    k = dispersion.wavenumber(2.0 * np.pi * frequency, depth)
    plane = np.zeros((frequency.size, direction.size))
    lines, kinds = np.zeros((len(known), frequency.size)), []
    for row, (_, waves, _) in enumerate(known):
        kinds.append(REGULAR)
        if isinstance(waves, RandomWaves):
            system = spectral_system(waves, depth)
            lines[row] = system.radial(k) * 2.0 * np.pi / dispersion.group_speed(k, depth)
            kinds[-1] = LONG_CRESTED if system.spreading is None else SHORT_CRESTED
            if system.spreading is not None:
                plane += directional_density(system, frequency, direction, depth)
    dataset = build(
        "sea/spectrum",
        {
            "directional_spectrum": plane,
            "frequency_spectrum": lines.sum(axis=0),
            "system_spectrum": lines,
            "system_kind": kinds,
            "system_height": [facts.height for _, _, facts in known],
            "system_period": [facts.peak_period for _, _, facts in known],
            "system_direction": [facts.from_deg for _, _, facts in known],
        },
        {"frequency": frequency, "direction": direction, "system": [number for number, _, _ in known]},
        {"resolved_up_to_hz": limit, **{f"sea_{name}": v for name, v in sea.spectrum.attrs.items()}},
    )
    dataset["system_kind"].attrs["flag_values"] = np.array([SHORT_CRESTED, LONG_CRESTED, REGULAR], dtype=np.int8)
    dataset["system_kind"].attrs["flag_meanings"] = "short_crested long_crested regular"
    return dataset


PRODUCTS = ("sea.nc", "statistics.txt", "directional_spectrum.png", "sea_surface.png", "sea.gif", "from_mast.png")
DEFAULT_TIMES = "0:5:0.5"

_MAST_PICTURE = (1280, 560)  # columns, rows
_FINEST_FILM = 700  # points a side that an animation is drawn from
_LEFT, _NOTHING = "and stay readable in sea.nc; the pictures are missing", "no results are left"

# Fields are rounded, by unit, to powers of two: below what the sea itself is exact to, and the digits beyond it do not
# compress.
ROUNDING = {"m": 2.0**-13, "1": 2.0**-14, "m s-1": 2.0**-11, "dB": 2.0**-6}


@dataclass(frozen=True)
class SeaProducts:
    """What was left behind: names of files in the folder, moments of all that is on file, and what was left out."""

    folder: Path
    files: tuple[str, ...]
    sea: Sea
    drawn: Moments
    side: float  # m, of the square of points
    notes: tuple[str, ...]

    def headline(self) -> str:
        """Wave height, and the resolved part of the sea, in one line."""
        resolved = self.sea.resolved
        share = resolved.choppy.folded_share if resolved.choppy is not None else 0.0
        folded = f"; {share:.2%} of the water folds over" if share > 0.0 else ""
        return (
            f"Hs {self.drawn.significant_height:.2f} m over {self.side:.3g} m × {self.side:.3g} m, "
            f"{requested_height(self.sea):.2f} m asked for; resolved "
            f"{resolved.variance_share:.2%} of the variance, {resolved.mean_square_slope_share:.0%} of the same "
            f"spectra's mean square slope{folded}"
        )


def write_sea(
    scene: Scene,
    out: str | Path,
    *,
    times: str = DEFAULT_TIMES,
    side: float | None = None,
    spacing: float | None = None,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> SeaProducts:
    """Write a scene's sea into a folder: sea.nc, a table of its statistics, pictures and an animation.

    times: START:STOP:STEP or T,T,… [s], see `times_of`. side, spacing: of the square of points around the antenna [m];
    default the radar's range circle, and the finest that is resolved, at most 512 points a side.
    Times stream into the file, so memory holds one. Interrupted, complete times stay readable.
    Raises InputError for bad input, NoBackendError if the scene asks for rays and none can be traced.
    """
    say, folder = progress or ignore_progress, Path(out)
    seconds = times_of(times)
    points = square_points(scene, side, spacing)
    with results_folder(folder, overwrite, PRODUCTS):
        refuse_too_large(folder, seconds.size, points.size)
        say("preparing the sea")
        simulator, drawn = Simulator(scene), Moments()
        sea = simulator.sea
        if seconds[-1] > sea.ends_s:
            raise InputError(
                f"--times {times}: must end at {sea.ends_s:.4g} s or before, where the record of sea.file ends; give "
                f"--times 0:{sea.ends_s:.3g}:0.5"
            )
        trace = tracer(scene.tracing.tracer, scene.radar, scene.scattering, diffraction=scene.tracing.diffraction)
        camera = Camera(scene, sea, lambda mesh: simulator.shaded(trace(mesh)), points, simulator.surface)
        spectrum = directional_spectrum(scene, sea)
        clear_folder(folder, PRODUCTS)
        with (
            note_growing(folder, ("sea.nc",), "times"),
            sea_file(folder / "sea.nc", spectrum) as file,
            report_partial_results(
                lambda: f"{file.complete} of {seconds.size} times are complete, {_LEFT if file.complete else _NOTHING}"
            ),
        ):
            for number, t in enumerate(seconds):
                say(f"time {number + 1} of {seconds.size}: {t:g} s")
                moment = camera.moment(float(t))
                file.append(moment)
                drawn.add(*(moment[name].values for name in ("sea_surface_height", "slope_x", "slope_y")))
        say("drawing")
        write_whole(folder / "statistics.txt", statistics_table(scene, sea, drawn, points.size * point_spacing(points)))
        notes = _draw(scene, sea, spectrum, folder)
        say("rendering the sea as the mast sees it")
        notes += _draw_from_mast(scene, sea, folder / "from_mast.png", float(seconds[0]))
        files = tuple(name for name in PRODUCTS if (folder / name).exists())
        spacing, finest = point_spacing(points), sea.resolved.resolution_m
        if spacing > 1.01 * finest and sea.trains:
            coarse = (
                f"sea.nc has a point every {spacing:.3g} m, the sea waves down to {2.0 * finest:.3g} m: values are "
                "right at each point, spectra and differences between them are not; "
                f"--spacing {finest:.3g} holds all waves"
            )
            notes = (coarse, *notes)
        return SeaProducts(folder, files, sea, drawn, points.size * spacing, notes)


def sea_file(path: Path, spectrum: xr.Dataset) -> AppendableNetCDF:
    """sea.nc: grows by times, holds the spectrum once, and packs its fields."""
    constant = {"spectrum": spectrum}
    return AppendableNetCDF(path, ("time",), constant=constant, compressed=True, rounding=ROUNDING)


# ---------------------------------------------------------------------------------------------------- the pictures


def _draw(scene: Scene, sea: Sea, spectrum: xr.Dataset, folder: Path) -> tuple[str, ...]:
    """The pictures of the spectrum and of what is on file; what could not be drawn and why."""
    figure = spectrum_figures.directional_spectrum(scene, spectrum, sea.resolved)
    (folder / "directional_spectrum.png").write_bytes(style.png(figure))
    with xr.open_dataset(folder / "sea.nc", decode_times=False) as moments:
        (folder / "sea_surface.png").write_bytes(style.png(sea_figures.sea_surface(scene, moments.isel(time=0))))
        if moments.sizes["time"] < 2:
            return ("sea.gif is left out: it needs two times",)
        every = slice(None, None, -(-moments.sizes["x"] // _FINEST_FILM))
        (folder / "sea.gif").write_bytes(sea_figures.animation(scene, moments.isel(x=every, y=every)))
    return ()


def _draw_from_mast(scene: Scene, sea: Sea, path: Path, t: float) -> tuple[str, ...]:
    """What an eye at the radar's height sees when it looks up the main waves; a note where that cannot be drawn."""
    from ..tracing.picture import View, render_from_mast

    waves = reduce.main_waves(scene)
    azimuth = waves.from_deg if waves is not None else 0.0
    view = View(height_m=scene.radar.height_m, azimuth_deg=azimuth, size=_MAST_PICTURE)
    ripples = ShortWaves.of(scene.scattering, sea.resolved.wavenumber_limit).mean_square_slope
    try:
        picture = render_from_mast(lambda x, y: sea.elevation(x, y, t), view, unresolved_mss=min(ripples, 0.2))
    except (NoBackendError, ValueError) as reason:
        return (f"from_mast.png is left out: {reason}",)
    imsave(path, picture)
    return ()
