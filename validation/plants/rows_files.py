"""Plants in files and in the command line."""

from __future__ import annotations

from .plant import Plant

_JOURNAL = "        if journal:\n            self._write_journal(json.dumps(dict(note)).encode())\n"
_PAGES = (
    "        for number, page in self._pages.items():\n"
    "            _write_at(self._handle, memoryview(page), number * _PAGE)\n"
)

PLANTS = (
    Plant(
        "journal before pages",
        "seamap_rt/io/committed_file.py",
        _JOURNAL + _PAGES,
        _PAGES + _JOURNAL,
        "tests/io/test_killed.py::test_each_write_leaves_a_file_with_its_whole_turns",
    ),
    Plant(
        "echo store's pulses",
        "seamap_rt/io/echo_store.py",
        '_describe(self.path, complete, start + turn.sizes["pulse"])',
        '_describe(self.path, complete, turn.sizes["pulse"])',
        "tests/io/test_killed.py::test_each_write_of_the_store_leaves_its_whole_turns",
    ),
    Plant(
        "a chunk that two turns share",
        "seamap_rt/io/growing_array.py",
        "        if before:\n",
        "        if before < 0:\n",
        "tests/io/test_growing_array.py::test_its_files_are_those_of_zarr_itself",
    ),
    Plant(
        "a store's file under its own name before it is whole",
        "seamap_rt/io/growing_array.py",
        '    partial = f"{file}{PARTIAL}"\n',
        '    partial = f"{file}"\n',
        "tests/io/test_growing_array.py::test_a_turn_that_the_disk_cannot_take_is_not_there",
    ),
    Plant(
        "a turn's chunk as it lies in memory",
        "seamap_rt/io/appendable.py",
        "enumerate(np.ascontiguousarray(values, dtype=array.hdf5.dtype), first)",
        "enumerate(np.ascontiguousarray(values), first)",
        "tests/io/test_appendable.py::test_what_goes_past_hdf5_lies_as_hdf5_itself_puts_it",
    ),
    Plant(
        "deep tables",
        "seamap_rt/io/scenefile.py",
        "    return bool(level)\n",
        "    return False\n",
        "tests/cli/test_cli_refusals.py::test_tables_in_tables_without_end_are_one_line",
    ),
    Plant(
        "null byte",
        "seamap_rt/io/validation.py",
        'isinstance(value, str) and "\\0" in value',
        'isinstance(value, str) and "\\0\\0" in value',
        "tests/cli/test_cli_refusals.py::test_a_null_byte_is_one_line",
    ),
    Plant(
        "too long a path",
        "seamap_rt/cli/application.py",
        '    errno.ENAMETOOLONG: "give a shorter path",\n',
        "",
        "tests/cli/test_cli_refusals.py::test_a_path_that_is_too_long_is_one_line",
    ),
    Plant(
        "terminal of ASCII",
        "seamap_rt/cli/application.py",
        "    _print_anywhere()\n",
        "",
        "tests/cli/test_cli_refusals.py::test_a_terminal_that_knows_ascii_alone_is_served",
    ),
    Plant(
        "an outlook without shadows",
        "seamap_rt/design_outlook/sight.py",
        "lit = 1.0 if view > horizon else 0.0",
        "lit = 1.0 if view > -1.0 else 0.0",
        "tests/design_outlook/test_outlook.py::test_shadows_of_a_regular_wave_are_those_of_the_closed_form",
    ),
    Plant(
        "an outlook's waves of twice the power",
        "seamap_rt/design_outlook/strips.py",
        "power[..., 1:] *= 0.25 ",
        "power[..., 1:] *= 0.5 ",
        "tests/design_outlook/test_outlook.py::test_strips_have_the_variance_and_the_slopes_of_the_sea_along_each_look",
    ),
    Plant(
        "a boat whose lean leaves the beam where it is",
        "seamap_rt/design_outlook/echo.py",
        "-link.grazing_angle(radar, ranges) - lean[:, None]",
        "-link.grazing_angle(radar, ranges) - 0.0 * lean[:, None]",
        "tests/design_outlook/test_motion.py::test_a_run_on_a_moving_boat_measures_as_much_as_the_outlook_says",
    ),
    Plant(
        "sensors whose late and askew angles cost an outlook nothing",
        "seamap_rt/design_outlook/motion.py",
        "ground**2 * (self.attitude[:, None] + attitude)",
        "ground**2 * (0.0 * self.attitude[:, None] + attitude)",
        "tests/design_outlook/test_motion.py::test_a_run_on_a_moving_boat_measures_as_much_as_the_outlook_says",
    ),
    Plant(
        "a beam over the sea taken for one on it",
        "seamap_rt/wavefield/hindrance.py",
        "abs(down - tilt) > 0.5 * width",
        "abs(down - tilt) > 5.0 * width",
        "tests/wavefield/test_hindrance.py::test_what_hinders_is_named_and_its_remedy_mends_it",
    ),
    Plant(
        "an outlook's echo without the elevation pattern",
        "seamap_rt/design_outlook/echo.py",
        "(losses.elevation if lean is None else 0.0)",
        "0.0",
        "tests/design_outlook/test_outlook.py::test_the_echo_is_that_of_the_link_budget",
    ),
    Plant(
        "an outlook's noise of half the pulses",
        "seamap_rt/design_outlook/error.py",
        "/ (2.0 * design.pulses)",
        "/ design.pulses",
        "tests/design_outlook/test_outlook.py::test_a_weak_dwell_is_as_good_as_the_bound_of_its_phase",
    ),
    Plant(
        "a score of errors without their tail",
        "seamap_rt/design_outlook/error.py",
        "np.sqrt(2.0 / np.pi) * np.exp(-0.5 * ratio**2) / ratio",
        "0.0 * ratio",
        "tests/design_outlook/test_outlook.py::test_a_score_is_the_mean_over_gaussian_errors",
    ),
    Plant(
        "a sign of the phase that is not tried",
        "seamap_rt/inspection/level.py",
        "if not least * _SURE <= level.rms:",
        "if True:",
        "tests/inspection/test_inspection.py::test_a_wrong_sign_is_surely_wrong_and_its_remedy_is_said",
    ),
    Plant(
        "a phase offset of the other sign",
        "seamap_rt/inspection/level.py",
        "np.array((-tilt, tilt_error))",
        "np.array((tilt, tilt_error))",
        "tests/inspection/test_inspection.py::test_a_phase_offset_is_found_and_told_in_degrees",
    ),
    Plant(
        "a receiver that is conjugated",
        "seamap_rt/inspection/receivers.py",
        "for each in (upper.conj(), upper))",
        "for each in (upper, upper.conj()))",
        "tests/inspection/test_inspection.py::test_samples_that_are_no_two_voltages_of_one_echo",
    ),
    Plant(
        "a level that strays is called good",
        "seamap_rt/inspection/level.py",
        "level.rms > _OF_MAST *",
        "level.rms < _OF_MAST *",
        "tests/inspection/test_inspection.py::test_a_phase_half_a_turn_off_is_not_called_good",
    ),
    Plant(
        "waves that run either way",
        "seamap_rt/inspection/motion.py",
        "if totals[0] > totals[1]:",
        "if totals[0] != totals[1]:",
        "tests/inspection/test_inspection.py::test_velocities_of_the_wrong_sign_are_found_by_the_next_turn",
    ),
    Plant(
        "MATLAB's dimensions as HDF5 has them",
        "seamap_rt/io/matlab.py",
        "    return values.T\n",
        "    return values\n",
        "tests/io/test_recorded.py::test_matlab_files_of_both_kinds_hold_the_same",
    ),
    Plant(
        "a turn retrieved twice while it is followed",
        "seamap_rt/session/retrieving.py",
        "retrieve_turns(echoes, settings, last)",
        "retrieve_turns(echoes, settings)",
        "tests/cli/test_cli_retrieving.py::test_turns_that_come_later_are_retrieved_once_each",
    ),
    Plant(
        "a GeoTIFF upside down",
        "seamap_rt/io/geotiff.py",
        "dtype=np.float32)[::-1] for band",
        "dtype=np.float32) for band",
        "tests/io/test_exports.py::test_a_north_east_cell_lies_north_east_in_the_picture",
    ),
    Plant(
        "half a cell aside",
        "seamap_rt/io/geotiff.py",
        "float(x[0]) - 0.5 * dx",
        "float(x[0])",
        "tests/io/test_exports.py::test_a_north_east_cell_lies_north_east_in_the_picture",
    ),
    Plant(
        "east and north exchanged on Earth",
        "seamap_rt/io/geography.py",
        "inverse.transform(east[known], north[known])",
        "inverse.transform(north[known], east[known])",
        "tests/io/test_exports.py::test_latitude_and_longitude_are_those_of_the_geodesic",
    ),
    Plant(
        "one line",
        "seamap_rt/errors.py",
        "each if each.isprintable() else _escaped(each)",
        "each",
        "tests/test_errors.py::test_refusals_are_one_printable_line",
    ),
    Plant(
        "signal while modules load",
        "seamap_rt/cli/stops.py",
        "os._exit(INTERRUPTED)",
        "os._exit(0)",
        "tests/cli/test_cli_interrupted.py::test_a_signal_while_modules_are_loaded_is_a_line",
    ),
)
