"""Plants in what files say of their numbers, in where a record begins, and in a vessel's file."""

from __future__ import annotations

from .plant import Plant

_IO, _LAWS = "seamap_rt/io/", "tests/io/test_declared.py::"
_START = "tests/sea/test_record_start.py::"
_VESSEL, _VESSELS = "seamap_rt/prediction/capytaine.py", "tests/prediction/test_capytaine.py::"

PLANTS = (
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
