"""Errors planted in laws of the physics, each of which a named judge must find.

python -m validation.plants [--only NAME]… [--workers 1]

A plant takes the place of a public function or method, in its module and wherever it was imported by name, and gives
wrong answers. Its judge, a test or a case of `seamap-rt validate`, is asked in a process of its own and must fail by a
check: red. GREEN: the judge does not find it. ERROR: the judge ended otherwise, or is not there. First all tests among
the judges are asked without a plant. Exit code 1 unless all is as it must be. Compiled loops do not meet the plants.
"""

from __future__ import annotations

import argparse
import importlib
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cached_property, reduce, wraps
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
_PLANTED = "SEAMAP_RT_PLANTED"  # name of the plant, in the judge's environment
_LONGEST_S = 300.0
_CASE = "case "
_FAILED = 1  # exit code of pytest and of `seamap-rt validate` where a check failed
_UNCHECKED = 3  # of a test that ended by an error before its check
_ASK_CASE = "import sys, seamap_rt.cli as cli, validation.plants as p; p.sow(); sys.exit(cli.main(sys.argv[1:]))"

Wrong = Callable[[Callable[..., Any]], Callable[..., Any]]


class Plant(NamedTuple):
    """name; at: "module:function" or "module:Class.method", of seamap_rt; wrong: makes the wrong function of the right
    one; judge: a pytest node of tests, or "case NAME"."""

    name: str
    at: str
    wrong: Wrong
    judge: str


# ------------------------------------------------------------------------------------------------------ wrong answers


def answers(change: Callable[[Any], Any]) -> Wrong:
    """The right answer, changed."""

    def wrong(right: Callable[..., Any]) -> Callable[..., Any]:
        return wraps(right)(lambda *args, **keys: change(right(*args, **keys)))

    return wrong


def asks(change: Callable[..., tuple[Any, ...]]) -> Wrong:
    """The right answer to other arguments: `change` takes and gives those by place."""

    def wrong(right: Callable[..., Any]) -> Callable[..., Any]:
        return wraps(right)(lambda *args, **keys: right(*change(*args), **keys))

    return wrong


def times(factor: float) -> Wrong:
    """The answer times a factor."""
    return answers(lambda found: factor * found)


def decibels(db: float) -> Wrong:
    """A power that is so many decibels off."""
    return times(10.0 ** (db / 10.0))


def each(*factors: float) -> Wrong:
    """A pair or more of answers, each times a factor of its own."""
    return answers(lambda found: tuple(factor * one for factor, one in zip(factors, found, strict=True)))


def part(name: str, change: Callable[[Any], Any]) -> Wrong:
    """One field of an answer, changed."""
    return answers(lambda found: replace(found, **{name: change(getattr(found, name))}))


def variable(name: str, change: Callable[[Any], Any]) -> Wrong:
    """One variable of a dataset that is answered, changed."""
    return answers(lambda found: found.assign({name: change(found[name])}))


def strong_short_waves(right: Callable[..., Any]) -> Callable[..., Any]:
    """A tenth more of waves shorter than 6 cm."""
    return lambda k, *args, **keys: right(k, *args, **keys) * np.where(np.asarray(k) > 100.0, 1.1, 1.0)


def widened(cut: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """A cut through a beam that is 5 % wide."""
    return lambda cosine: cut(np.asarray(cosine) / 1.05)


# ---------------------------------------------------------------------------------------------------------- the table

# fmt: off
PLANTS = (
    # Sea
    Plant("wavenumbers 2 % too large", "physics.dispersion:wavenumber", times(1.02),
          "sea/test_dispersion.py::test_gravity_waves_agree_with_the_table_to_its_printed_digits"),
    Plant("shallow water's orbits taken for circles", "physics.dispersion:orbital_ratio", answers(np.ones_like),
          "sea/test_moving_field.py::test_every_quantity_is_its_exact_sum"),
    Plant("a current that carries waves the other way", "physics.dispersion:Water.doppler_shift", times(-1.0),
          "wavefield/test_finite_depth.py::test_a_ground_map_at_one_instant_runs_on_with_the_current"),
    Plant("JONSWAP with 5 % too much energy", "sea.spectra:jonswap", times(1.05),
          "sea/test_wavespectra.py::test_jonswap_of_a_height_and_period"),
    Plant("short waves of Elfouhaily a tenth too strong", "sea.spectra:elfouhaily97", strong_short_waves,
          "sea/test_elfouhaily.py::test_moments_meet_the_check_values"),
    Plant("spreading of twice the exponent", "physics.wave_spectra:cos2s",
          asks(lambda angle, exponent: (angle, 2.0 * exponent)),
          "sea/test_spectra.py::test_cos2s_integrates_to_one_about_its_mean_direction"),
    Plant("waves that run where they come from", "sea.systems:travel_direction", each(-1.0, -1.0),
          "sea/test_surface.py::test_waves_from_the_west_travel_east"),
    Plant("slopes of the surface upside down", "sea.surface:Sea.slopes", times(-1.0),
          "sea/test_surface.py::test_sinusoid_is_its_closed_form"),
    Plant("choppy waves without a mean level", "sea.choppy:ChoppySurface.set_down", times(0.0),
          "sea/test_choppy.py::test_a_regular_wave_has_its_second_harmonic_and_no_mean"),
    Plant("nonlinear water that rises 1 % too fast", "sea.high_order.rates:Rates.vertical_velocity", times(1.01),
          "sea/test_high_order.py::test_the_vertical_velocity_errs_as_published"),
    Plant("a recorded sea a frame late", "sea.recorded:first_frame", answers(lambda frame: frame + 1),
          "sea/test_recorded_seas.py::test_a_recorded_sea_is_the_one_that_was_drawn"),
    # Scattering
    Plant("HH taken for VV", "scattering.bragg:bragg_coefficients", answers(lambda found: found[::-1]),
          "scattering/test_bragg.py::test_vv_is_never_below_hh_and_they_meet_at_the_vertical"),
    Plant("sea clutter 0.5 dB too weak", "scattering.empirical:nrcs_gregers_hansen12", decibels(-0.5),
          "case nrl_sea_clutter"),
    Plant("strain that thins the waves which it gathers", "scattering.breaking:action_modulation",
          answers(np.reciprocal),
          "scattering/test_modulation.py::test_breaking_goes_like_the_sixth_power_of_the_spectrum_where_little_breaks"),
    Plant("half as many sea spikes again", "scattering.sea_spikes:SeaSpikes.density", times(1.5),
          "echoes/test_spike_field.py::test_the_mean_is_one_at_every_range_and_look"),
    # Mesh and light
    Plant("facets 1 % too large", "mesh.facets:facets_of", part("horizontal_area", lambda area: 1.01 * area),
          "mesh/test_polar_mesh.py::test_horizontal_areas_fill_the_polygon"),
    Plant("Smith's sea 5 % too dark", "physics.shadowing:shadowing_smith67", times(0.95),
          "physics/test_shadowing.py::test_smith_and_wagner_are_the_judges"),
    Plant("a horizon that hides nothing", "tracing.horizon:trace_horizon", part("lit", np.ones_like),
          "tracing/test_tracers.py::TestAgainstTheExactSinusoid::test_whole_window_by_a_target"),
    Plant("edges that bend waves of twice the length", "tracing.diffraction:diffract",
          asks(lambda light, mesh, wavelength: (light, mesh, 2.0 * wavelength)),
          "tracing/test_diffraction.py::test_one_ridge"),
    Plant("the Earth falling away by its own radius", "physics.shadowing:earth_drop_m", times(4.0 / 3.0),
          "physics/test_propagation.py::test_the_earth_falls_away_as_a_sphere"),
    # Radar
    Plant("a beam 5 % too wide", "radar.antenna:antenna_of", part("azimuth", widened),
          "radar/test_antenna.py::test_beam_widths_are_those_asked_for"),
    Plant("paths of alternating pulses counted once", "radar.array:Array.phase_paths", answers(lambda _: 1),
          "radar/test_array.py::test_the_cycle_is_that_of_the_table"),
    Plant("a pulse 5 % too short", "radar.waveform:RangeResponse.__call__",
          asks(lambda response, offset: (response, 1.05 * np.asarray(offset))),
          "radar/test_waveform.py::test_pulse_is_the_convolution_of_a_rectangle_with_the_filter"),
    Plant("a receiver 1 dB too noisy", "radar.receiver:noise_power", decibels(1.0),
          "echoes/test_turn.py::test_noise_power"),
    Plant("echoes 0.5 dB too weak", "radar.receiver:amplitude_constant", decibels(-0.25),
          "case radar_equation"),
    Plant("an antenna that turns anticlockwise", "radar.scan:pulses", part("azimuth", lambda azimuth: -azimuth % 360.0),
          "radar/test_scan.py::test_a_sectors_pulses_are_those_within_it"),
    Plant("a boat that rolls to port", "radar.pose:boat_axes",
          asks(lambda attitude: (np.asarray(attitude) * (-1.0, 1.0, 1.0),)),
          "radar/test_pose.py::test_roll_is_starboard_down"),
    Plant("sensors twice as late", "radar.platform:Sensors.__call__",
          asks(lambda sensors, time: (sensors, np.asarray(time) - sensors.settings.latency_s)),
          "radar/test_sensors.py::test_a_late_reading_is_of_the_motion_before"),
    # Echoes
    Plant("phases of point scatterers that turn backwards", "echoes.scatterers:scatterer_voltages", answers(np.conj),
          "echoes/test_phase_exactness.py::test_scatterer_phase"),
    Plant("moving speckle that recedes where it approaches", "echoes.speckle:MovingSpeckle.modes",
          answers(lambda kinds: tuple(np.conj(kind) for kind in kinds)),
          "echoes/test_doppler.py::test_doppler_in_the_voltages"),
    Plant("speckle that lives a fifth too long", "echoes.speckle:speckle_basis",
          asks(lambda nodes, spacing, tau, *window: (nodes, spacing, 1.2 * tau, *window)),
          "echoes/test_speckle_basis.py::test_what_is_heard_goes_on_by_its_law"),
    Plant("scatterers that run against the wind", "echoes.radar_cross_section:SeaSurface.wind",
          answers(lambda angle: angle + np.pi),
          "echoes/test_radar_cross_section.py::test_scatterers_run_down_wind"),
    # Retrieval
    Plant("a baseline 2 % too long", "interferometry.inversion:located",
          asks(lambda gate, difference, fan: (gate, np.divide(difference, 1.02), fan)),
          "case tilted_plane"),
    Plant("phases over mean level with the wrong sign", "interferometry.poses:PhaseModel.residual",
          times(-1.0),
          "case sinusoid"),
    Plant("velocities with the wrong sign", "interferometry.velocity:phase_rate", times(-1.0),
          "interferometry/test_velocity.py::test_what_recedes_has_a_positive_velocity"),
    Plant("coherence that keeps its noise", "interferometry.windows:without_noise",
          lambda right: lambda covariance, noise_power: covariance,
          "interferometry/test_dwell_sums.py::test_the_coherence_without_noise_is_the_echos"),
    Plant("phases' error bars times 0.8", "interferometry.speckle:phase_variances", each(0.64, 0.64),
          "interferometry/test_speckle.py::test_strong_echoes_have_good_phases"),
    Plant("cycles taken off instead of added", "interferometry.ambiguity:resolve", part("cycles", np.negative),
          "interferometry/test_unwrapping.py::test_a_sea_beyond_the_ambiguity"),
    Plant("sensors' errors times 0.8", "interferometry.error_covariance:sensor_variance", times(0.64),
          "interferometry/test_sensor_errors.py::test_each_key_has_its_closed_form"),
    Plant("a sea's covariance a fifth too small", "interferometry.sea_covariance:SeaCovariance.of",
          part("table", lambda table: 0.8 * table),
          "interferometry/test_sea_covariance.py::test_the_covariance_is_the_seas"),
    Plant("planes that rise towards the radar", "interferometry.slopes:local_planes",
          part("outward", np.negative),
          "interferometry/test_slopes.py::test_a_plane_comes_back"),
    Plant("ground maps one square to the east", "interferometry.ground_map:square_means",
          answers(lambda found: np.roll(found, 1, axis=-1)),
          "interferometry/test_ground_maps.py::test_squares_are_means_of_bilinear_values"),
    # Waves from maps, forecasts
    Plant("significant height 5 % too small", "wavefield.sea_state:sea_state",
          variable("significant_wave_height", lambda height: 0.95 * height),
          "wavefield/test_sea_state.py::test_one_wave_is_found_as_it_is"),
    Plant("maps' waves that run where they come from", "wavefield.wave_direction:travel",
          answers(lambda found: replace(found, east=-found.east, north=-found.north)),
          "wavefield/test_wave_direction.py::test_the_direction_is_found_without_its_ambiguity"),
    Plant("waves that shift each other 10 % too little", "physics.dispersion:mutual_shift", times(0.9),
          "physics/test_amplitude_dispersion.py::test_a_strong_wave_shifts_weak_ones_as_in_the_nonlinear_sea"),
    Plant("observations that weigh four times too much", "prediction.assimilation:weights", each(4.0, 1.0),
          "prediction/test_fit.py::"
          "test_few_observations_weigh_by_their_errors_and_many_of_one_place_no_more_than_some"),
    Plant("slopes of the fitted sea upside down", "prediction.spectrum:factor", answers(np.conj),
          "prediction/test_forecast.py::test_slopes_and_velocity_are_derivatives_of_elevation"),
    Plant("forecasts' error bars times 0.8", "prediction.field:WaveField.predict",
          answers(lambda found: [(mean, 0.8 * std) for mean, std in found]),
          "prediction/test_fit.py::test_errors_are_those_of_the_conditional_sea"),
    Plant("quiet windows of half the time", "prediction.forecast:quiet_windows",
          asks(lambda forecast, limit, duration_s: (forecast, limit, 0.5 * duration_s)),
          "prediction/test_forecast.py::test_windows_count_the_draws_in_which_all_limits_hold_throughout"),
    Plant("a boat that rolls against the waves' slope", "prediction.vessel:Box.response", part("roll", np.negative),
          "prediction/test_vessel.py::test_a_boat_lies_on_a_long_wave_as_its_ends_and_sides_do"),
    # What judges
    Plant("a true sea 1 cm too high", "truth.polar:polar_truth", variable("height", lambda height: height + 0.01),
          "test_truth.py::test_cell_means_of_a_regular_wave"),
)
# fmt: on


# --------------------------------------------------------------------------------------------------------- the runner


def sow() -> None:
    """Plants the error that the environment names, in whatever is loaded by now and in its own module."""
    plant = next(plant for plant in PLANTS if plant.name == os.environ[_PLANTED])
    module, _, path = plant.at.partition(":")
    *owners, name = path.split(".")
    owner: Any = reduce(getattr, owners, importlib.import_module(f"seamap_rt.{module}"))
    right = vars(owner)[name]
    wrong = _wrong_of(right, plant.wrong)
    if owners:
        setattr(owner, name, wrong)
        if isinstance(wrong, cached_property):
            wrong.__set_name__(owner, name)
        return
    for loaded in [each for each in list(sys.modules.values()) if isinstance(each, ModuleType)]:
        for key in [key for key, value in vars(loaded).items() if value is right]:
            setattr(loaded, key, wrong)


def _wrong_of(right: Any, wrong: Wrong) -> Any:
    if isinstance(right, property):
        assert right.fget is not None
        return property(wrong(right.fget))
    if isinstance(right, cached_property):
        return cached_property(wrong(right.func))
    return type(right)(wrong(right.__func__)) if isinstance(right, (classmethod, staticmethod)) else wrong(right)


def pytest_collection_finish() -> None:
    """Once all tests are loaded; pytest calls this of a plugin."""
    if _PLANTED in os.environ:
        sow()


def pytest_exception_interact(node: Any, call: Any) -> None:
    """A test that ends by another error than its check's finds nothing; pytest calls this of a plugin."""
    if not _is_check(call.excinfo.value):
        node.session.unchecked = True


def pytest_sessionfinish(session: Any, exitstatus: int) -> None:
    """The exit code that says so; pytest calls this of a plugin."""
    if exitstatus == _FAILED and hasattr(session, "unchecked"):
        session.exitstatus = _UNCHECKED


def _is_check(error: BaseException) -> bool:
    if isinstance(error, BaseExceptionGroup):  # of several examples
        return all(map(_is_check, error.exceptions))
    return isinstance(error, AssertionError) or type(error).__name__ == "Failed"  # pytest's own


def ask(judges: Sequence[str], name: str | None = None) -> tuple[str, str]:
    """Asks tests, or one case, with the plant of that name, if any: what was seen, in a word, and the output."""
    tests = [str(ROOT / "tests" / judge) for judge in judges]
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-p",
        "validation.plants",
        "-p",
        "no:cacheprovider",
        "-n0",
        "-xq",
        *tests,
    ]
    threads = dict.fromkeys(("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    environment = {**os.environ, **threads, **({_PLANTED: name} if name else {})}
    with tempfile.TemporaryDirectory(prefix="judge-") as out:
        if judges[0].startswith(_CASE):
            case = judges[0].removeprefix(_CASE)
            command = [sys.executable, "-c", _ASK_CASE, "validate", "--only", case, "--out", f"{out}/report"]
        try:
            done = subprocess.run(
                command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=_LONGEST_S, check=False
            )
        except subprocess.TimeoutExpired:
            return f"ERROR (not done after {_LONGEST_S:g} s)", ""
    word = {0: "GREEN", _FAILED: "red"}.get(done.returncode, f"ERROR (code {done.returncode})")
    return word, done.stdout + done.stderr


def run(plants: Sequence[Plant], workers: int, say: Callable[[str], None]) -> list[str]:
    """Asks the tests without a plant, then each judge with its own; names of what was not as it must be."""
    wrong = []

    def report(name: str, judges: list[str], planted: str | None) -> None:
        begun = time.perf_counter()
        word, output = ask(judges, planted)
        say(f"{name:50s} {judges[0] if planted else len(judges):<110} {time.perf_counter() - begun:5.1f} s  {word}")
        if word != ("red" if planted else "GREEN"):
            wrong.append(name)
            say("    " + "\n    ".join(output.strip().splitlines()[-12:]))

    tests = [plant.judge for plant in plants if not plant.judge.startswith(_CASE)]
    if tests:
        report("nothing planted", list(dict.fromkeys(tests)), None)
    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(lambda plant: report(plant.name, [plant.judge], plant.name), plants))
    return wrong


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", metavar="NAME", action="append", default=[], help="plants whose name holds this")
    parser.add_argument("--workers", type=int, default=1, help="judges that are asked at a time")
    arguments = parser.parse_args()
    plants = [plant for plant in PLANTS if not arguments.only or any(name in plant.name for name in arguments.only)]
    if not plants or arguments.workers < 1:
        parser.error("--only must be held by a plant's name, and --workers be at least 1")
    wrong = run(plants, arguments.workers, lambda line: print(line, flush=True))
    if wrong:
        print(f"not as they must be: {', '.join(wrong)}")
    print("\n|  | planted | not as they must be |\n|---|---|---|")
    print(f"| errors in laws | {len(plants)} | {len(wrong)} |")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
