"""A turn from its sea to its maps, on the processor and on Dr.Jit's device: seconds, kernels and bytes, by stage.

    python -m validation.speed.device [--scene choppy_sea] [--repeat 5] [--set KEY=VALUE]…

Both ways take the same mesh, one after the other, so that seconds compare. Processor time counts, on LLVM, what the
threads of Dr.Jit do as well; on a CUDA machine look at the wall. Bytes are those that cross between host and device
(`moved`), of the processor's way those for the ray tracer. The sea is that of one turn after another, with the FFTs of
its new knots, which are the host's, and in a third table the device's (NumPy's on LLVM); the covariance is the means
over dwells that are taken from the voltages, and the windows are one of 5 gates by 3 looks about each cell. Then come
the kernels of one batch of columns, and last what the ways differ by.
"""

from __future__ import annotations

import argparse
import os
import statistics
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr

from seamap_rt.compute.device import device, moved
from seamap_rt.compute.machine import threads
from seamap_rt.compute.placement import SEA, SEA_FFT
from seamap_rt.echoes.dataset import echo_dataset
from seamap_rt.echoes.receiving import Received
from seamap_rt.echoes.returns_on_device import returns_on_device
from seamap_rt.echoes.summation import COLUMNS_ON_DEVICE
from seamap_rt.echoes.turn import Hearing, turn_echoes
from seamap_rt.echoes.turn_on_device import SumsOnDevice, turn_echoes_on_device
from seamap_rt.echoes.unheard import share_unheard
from seamap_rt.interferometry.covariance.dwell_sums import DwellSums, Paired
from seamap_rt.interferometry.covariance.windows import Covariance, PhaseSlopes
from seamap_rt.interferometry.input.description import RadarDescription
from seamap_rt.interferometry.looks import Looks
from seamap_rt.mesh import SurfaceMesh, polar_grid
from seamap_rt.mesh.on_device import MeshOnDevice
from seamap_rt.mesh.surface import sea_on_grid
from seamap_rt.radar.scan import pulses
from seamap_rt.scene import load_scene
from seamap_rt.simulation import Simulator
from seamap_rt.tracing.rays import RayTracer
from seamap_rt.truth import polar_truth, polar_truth_on_device
from seamap_rt.truth.on_device import FacetsOnDevice

Step = tuple[str, Callable[[], Any]]


@dataclass
class Taken:
    """What a stage took."""

    wall: list[float]
    processor: list[float]
    up: int = 0
    down: int = 0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="choppy_sea")
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    arguments = parser.parse_args()
    given = dict(each.split("=", 1) for each in arguments.set)
    made = Simulator(load_scene(arguments.scene, overrides={key: _value(text) for key, text in given.items()}))
    if not isinstance(made._trace, RayTracer):
        parser.error("--scene must have tracing.tracer = facets and no diffraction; choose another")
    print(f"{device().dr.__name__} on {type(device().Float(0.0)).__module__}, {arguments.scene}")
    mesh = made.mesh(0)
    facets = mesh.facets.height.size
    results = {}
    ways = ("processor", _on_processor), ("device", _on_device), ("device with the sea's FFTs", _with_ffts)
    for way, steps in ways:
        taken: dict[str, Taken] = {}
        for repeat in range(arguments.repeat + 1):  # the first compiles
            results[way] = _walk(steps(made, replace(mesh), repeat), taken if repeat else {})
        _show(way, taken, facets)
    _show_kernels(made, mesh)
    one, other, third = (results[way] for way, _ in ways)
    height = float(np.nanmax(np.abs(other["truth"]["height"].values - one["truth"]["height"].values)))
    print(f"differ, relative rms: voltages {_apart(one['echo'].voltage, other['echo'].voltage):.1e}", end="; ")
    print(f"covariance {_apart(one['sums'].one.cross, other['sums'].one.cross):.1e}", end="; ")
    print(f"windows {_apart(one['windows'].cross, other['windows'].cross):.1e}", end="; ")
    for name, sea in ("sea ", other["sea"]), ("of FFTs there ", third["sea"]):
        print(name + ", ".join(f"{_apart(a, b):.1e}" for a, b in zip(one["sea"], sea, strict=True)), end="; ")
    print(f"heights of the truth {height:.1e} m at most")


def _apart(one: Any, other: Any) -> float:
    one, other = np.asarray(one), np.asarray(other)
    return float(np.sqrt(np.nanmean(np.abs(other - one) ** 2) / np.nanmean(np.abs(one) ** 2)))


def _value(text: str) -> Any:
    import tomllib

    return tomllib.loads(f"value = {text}")["value"]


def _walk(steps: Iterator[Step], taken: dict[str, Taken]) -> Any:
    """Take the steps; the result of the last, which is all that is kept."""
    of, result = device(), None
    for name, step in steps:
        moved.forget()
        wall, processor = time.perf_counter(), time.process_time()
        result = step()
        of.dr.sync_thread()
        wall, processor = time.perf_counter() - wall, time.process_time() - processor
        each = taken.setdefault(name, Taken([], []))
        each.wall.append(wall)
        each.processor.append(processor)
        each.up, each.down = moved.up_bytes, moved.down_bytes
    return result


def _show(way: str, taken: dict[str, Taken], facets: int) -> None:
    print(f"\n{way}, {facets:,} facets\n{'stage':>12} wall s  cpu s  MB up MB down  bytes a facet up, down")
    for name, each in taken.items():
        wall, processor = statistics.median(each.wall), statistics.median(each.processor)
        print(
            f"{name:>12} {wall:6.3f} {processor:6.3f} {each.up / 1e6:6.2f} {each.down / 1e6:7.2f}"
            f"  {each.up / facets:.2f}, {each.down / facets:.2f}"
        )


def _show_kernels(made: Simulator, mesh: SurfaceMesh) -> None:
    """Those that sum one batch of columns, in the order in which they run."""
    dr, fired, there = device().dr, pulses(made.radar, 0, made.mast), MeshOnDevice.of(mesh)
    assert isinstance(made._trace, RayTracer)
    light = made._trace.on_device(mesh.levelled, there.levelled)
    returns = returns_on_device(made.surface, mesh.levelled.facets, there.levelled, light)
    hearing = Hearing.of(mesh.facets, made.radar, fired, *_speckle(made), returns.motion, 0.0, returns.fastest(there))
    heights = float(mesh.facets.height.min()), float(mesh.facets.height.max())
    sums, columns = SumsOnDevice(hearing, there, light, returns, heights), slice(0, COLUMNS_ON_DEVICE)
    sums(columns)
    dr.sync_thread()
    dr.kernel_history_clear()
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        sums(columns)
        dr.sync_thread()
    print(f"\nkernels of {columns.stop} columns: lanes, ms of {threads()} threads")
    for kernel in dr.kernel_history():
        if kernel["size"] > COLUMNS_ON_DEVICE and kernel["execution_time"] > 0.5:
            print(f"{kernel['size']:>12,} {kernel['execution_time']:8.1f}")


def _speckle(made: Simulator) -> tuple[int, float]:
    return made.scene.seed, made.scene.scattering.decorrelation_time_s


def _sea(made: Simulator, turn: int, kept: dict[str, Any], word: str, ffts: str = "processor") -> None:
    os.environ[SEA], os.environ[SEA_FFT] = word, ffts
    grid = polar_grid(made.radar, made.scene.meshing, turn, made.mast)
    kept["sea"] = sea_on_grid(made.sea, grid, made.surface.memory_rate)


def _echoes(made: Simulator, received: Received) -> xr.Dataset:
    return echo_dataset(made.radar, [pulses(made.radar, 0, made.mast)], [received], sensed=made.sensed)


def _covariance(made: Simulator, echoes: xr.Dataset) -> Callable[[], Any]:
    """What takes it, of looks that are known."""
    radar, settings = RadarDescription.of(echoes), made.scene.retrieval
    looks = Looks.of(echoes, radar, settings)
    time, given = looks.pulses.time, (looks.voltage, looks.transmitter)
    _ = looks.dwells.usual

    def take() -> DwellSums:
        paired = Paired.of(*given, time, looks.antennas, radar, settings)
        return DwellSums.of(*given, time, paired, looks.dwells, looks.antennas, radar, settings)

    return take


def _windows(covariance: Covariance) -> Covariance:
    level = np.zeros(covariance.lower.shape)
    return covariance.windowed_along(np.ones(5), np.ones(3), PhaseSlopes(level, level))


def _on_processor(made: Simulator, mesh: SurfaceMesh, turn: int) -> Iterator[Step]:
    fired, kept = pulses(made.radar, 0, made.mast), dict[str, Any]()
    yield "sea", lambda: _sea(made, turn, kept, "processor")
    unheard = share_unheard(made.sea.resolved.elevation_std, made.scene.tracing.height_error_m)
    yield "facets", lambda: kept.update(facets=mesh.facets, strain=mesh.strain, levelled=mesh.levelled.facets)
    yield "light", lambda: kept.update(light=made._trace(mesh.levelled))
    yield "scattering", lambda: kept.update(returns=made.surface(kept["light"], mesh.strain))
    lit, returns = kept["light"].on(mesh.facets), kept["returns"]
    if returns.running is not None:
        lit = replace(lit, velocity_look=lit.velocity_look + returns.running)
    heard = made.radar, fired, *_speckle(made)
    yield (
        "echoes",
        lambda: kept.update(echo=turn_echoes(lit, returns.rcs, *heard, returns.motion, unheard=unheard)),
    )
    truth = made.radar, made.scene.retrieval, 0
    yield "truth", lambda: kept.update(truth=polar_truth(kept["light"].on(mesh.facets), returns.rcs, *truth))
    take = _covariance(made, _echoes(made, kept["echo"]))
    yield "covariance", lambda: kept.update(sums=take())
    yield "windows", lambda: {**kept, "windows": _windows(kept["sums"].one)}


def _with_ffts(made: Simulator, mesh: SurfaceMesh, turn: int) -> Iterator[Step]:
    kept = dict[str, Any]()

    def take() -> dict[str, Any]:
        _sea(made, turn, kept, "device", "device")
        return kept

    yield "sea", take


def _on_device(made: Simulator, mesh: SurfaceMesh, turn: int) -> Iterator[Step]:
    fired, kept, dr = pulses(made.radar, 0, made.mast), dict[str, Any](), device().dr
    yield "sea", lambda: _sea(made, turn, kept, "device")
    unheard = share_unheard(made.sea.resolved.elevation_std, made.scene.tracing.height_error_m)
    assert isinstance(made._trace, RayTracer)
    trace = made._trace
    _ = mesh.facets, mesh.levelled.facets  # the rays' fronts are still the host's

    def place() -> None:
        kept["mesh"] = MeshOnDevice.of(mesh)
        dr.eval(kept["mesh"].levelled.elevation)

    yield "facets", place
    there = kept["mesh"]
    yield "light", lambda: kept.update(light=trace.on_device(mesh.levelled, there.levelled))
    light, facets = kept["light"], mesh.levelled.facets
    yield "scattering", lambda: kept.update(returns=returns_on_device(made.surface, facets, there.levelled, light))
    returns = kept["returns"]
    heard = mesh.facets, there, light, returns, made.radar, fired, *_speckle(made)
    yield "echoes", lambda: kept.update(echo=turn_echoes_on_device(*heard, unheard=unheard))
    seen, truth = FacetsOnDevice(mesh.facets, there, light, returns), (made.radar, made.scene.retrieval, 0)
    yield "truth", lambda: kept.update(truth=polar_truth_on_device(seen, *truth))
    take = _covariance(made, _echoes(made, kept["echo"]))
    yield "covariance", lambda: kept.update(sums=take())
    yield "windows", lambda: {**kept, "windows": _windows(kept["sums"].one)}


if __name__ == "__main__":
    main()
