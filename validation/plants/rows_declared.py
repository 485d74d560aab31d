"""Plants in what files say of their numbers, in where a record begins, and in a vessel's file."""

from __future__ import annotations

from .plant import Plant

_IO, _LAWS = "seamap_rt/io/", "tests/io/test_declared.py::"
_START = "tests/sea/test_record_start.py::"
_SPECTRA, _KINDS, _TEXT = (f"tests/io/test_{each}.py::" for each in ("declared_spectra", "spectrum_kinds", "text"))
_VESSEL, _VESSELS = "seamap_rt/prediction/capytaine.py", "tests/prediction/test_capytaine.py::"

PLANTS = (
    Plant(
        "units: a radian is no dimension",
        _IO + "units.py",
        '("rad radian radians", 1.0, {"angle": 1})',
        '("rad radian radians", 1.0, {})',
        "tests/io/test_units.py::test_every_spelling_has_its_size",
    ),
    Plant(
        "units: what follows a unit is passed over",
        _IO + "units.py",
        "        if token is None:\n            return None",
        "        if token is None:\n            break",
        "tests/io/test_units.py::test_what_is_of_another_kind_has_none",
    ),
    Plant(
        "spectra: directions to are directions from",
        _IO + "declared_spectrum.py",
        'return degrees + (180.0 if sense == "to" else 0.0)',
        "return degrees",
        _SPECTRA + "test_directions_are_as_words_describe_them",
    ),
    Plant(
        "spectra: a valid range is read past",
        _IO + "declared_spectrum.py",
        "density.copy(data=within_valid_range(density.to_numpy(), density.attrs, density.encoding))",
        "density",
        _SPECTRA + "test_what_lies_beyond_its_valid_range_is_missing",
    ),
    Plant(
        "spectra: no date is a date",
        _IO + "spectrumfile.py",
        "known = np.flatnonzero(~np.isnat(times))",
        "known = np.arange(times.size)",
        _SPECTRA + "test_no_date_is_nearest_to_nothing",
    ),
    Plant(
        "spectra: SWAN's NetCDF counts directions in degrees",
        _IO + "spectrum_layouts.py",
        'if layout.angle and "units" not in',
        'if not layout and "units" not in',
        _KINDS + "test_every_kind_is_the_same_sea",
    ),
    Plant(
        "spectra: a height that a buoy states is read past",
        _IO + "spectrum_layouts.py",
        "density = density.assign_coords(stated_height=height)\n    return",
        "pass\n    return",
        _KINDS + "test_a_buoy_that_states_another_height_is_refused",
    ),
    Plant(
        "text: numbers are Python's",
        _IO + "text.py",
        'if isinstance(text, str) and ("_" in text or not text.isascii()):',
        "if isinstance(text, str) and not text:",
        _TEXT + "test_no_command_takes_one",
    ),
    Plant(
        "text: libraries read Python's numbers",
        _IO + "spectrum_layouts.py",
        "refuse_underscores(content",
        "str(content",
        _TEXT + "test_no_spectrum_has_one_either",
    ),
    Plant(
        "declared: packing is left",
        _IO + "recorded.py",
        "return decoded(node[()], node.attrs, name)",
        "return node[()]",
        _LAWS + "test_packed_numbers_are_unpacked",
    ),
    Plant(
        "declared: a fill value is a number",
        _IO + "declared.py",
        "return np.ma.masked_array(values, missing) if missing.any() else values",
        "return values",
        _LAWS + "test_missing_numbers_are_missing",
    ),
    Plant(
        "declared: units are read past",
        _IO + "declared.py",
        "return to_unit(values, declared, unit, name)",
        "return values",
        _LAWS + "test_declared_units_are_converted",
    ),
    Plant(
        "declared: a mask of a program's array is read past",
        "seamap_rt/interferometry/input/recorded.py",
        "voltage[:, receiver][gone] = np.nan",
        "pass",
        _LAWS + "test_masked_arrays_and_dates_of_a_program_are_taken_as_a_files",
    ),
    Plant(
        "declared: any PRF",
        "seamap_rt/interferometry/input/recorded.py",
        "if not least <= heights <= most:",
        "if not 0.0 < heights:",
        _LAWS + "test_numbers_without_units_that_can_be_none_are_refused",
    ),
    Plant(
        "declared: an attribute of one entry stays an array",
        _IO + "recording_header.py",
        "plain(plain_attribute(value)) if",
        "plain(value) if",
        _LAWS + "test_a_header_of_attributes_of_one_entry_is_a_header",
    ),
    Plant(
        "record's start: between two frames",
        "seamap_rt/sea/recorded.py",
        "t + self.late_s, quantities",
        "t, quantities",
        _START + "test_a_run_is_the_record_from_there_on",
    ),
    Plant(
        "record's start: its waves at time 0",
        "seamap_rt/sea/recorded.py",
        "if frame == start:",
        "if frame == first:",
        _START + "test_a_run_is_the_record_from_there_on",
    ),
    Plant(
        "record's start: the file's first time",
        _IO + "recorded_sea.py",
        "begin_s=float(times[0]),",
        "begin_s=0.0,",
        _START + "test_a_run_is_the_record_from_there_on",
    ),
    Plant(
        "vessel's file: port and starboard of pitch",
        _VESSEL,
        '"Pitch": (1.0, -1.0)',
        '"Pitch": (-1.0, -1.0)',
        _VESSELS + "test_directions_left_out_follow_by_the_boats_symmetry",
    ),
    Plant(
        "vessel's file: a round boat's turn",
        _VESSEL,
        "[[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]",
        "[[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]",
        _VESSELS + "test_directions_left_out_follow_by_the_boats_symmetry",
    ),
    Plant(
        "vessel's file: where one of two bodies is",
        _VESSEL,
        "force * np.exp(-1j * k[:, None]",
        "force * np.exp(1j * k[:, None]",
        _VESSELS + "test_each_of_two_bodies_moves_as_it_would_alone",
    ),
    Plant(
        "vessel's file: frequencies without numbers",
        _VESSEL,
        "order = order[known[order]]",
        "order = order[np.isfinite(omega[order])]",
        _VESSELS + "test_frequencies_without_numbers_are_left_out_and_named",
    ),
    Plant(
        "pattern: known by its ending",
        _IO + "patternfile.py",
        "    if any(line.split()[0].upper()",
        "    if path.suffix == '.msi' and any(line.split()[0].upper()",
        "tests/radar/test_pattern_file.py::test_a_pattern_is_known_by_its_content_whatever_its_ending",
    ),
)
