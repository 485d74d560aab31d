"""Plants in recorded seas: their files, their gaps, and what goes on beyond them."""

from __future__ import annotations

from .plant import Plant

_IO, _SEA = "seamap_rt/io/", "seamap_rt/sea/"
_CONTINUED, _HOSTILE = "tests/sea/test_continued_seas.py::", "tests/sea/test_hostile_records.py::"
_GAPS, _STEREO = "tests/io/test_gaps.py::", "tests/io/test_stereo_layouts.py::"

PLANTS = (
    Plant(
        "recorded sea: a mirror a point off",
        _SEA + "continued.py",
        'mode="symmetric"',
        'mode="reflect"',
        _CONTINUED + "test_a_mirrored_sea_goes_on_without_a_step_and_its_slopes_change_sign",
    ),
    Plant(
        "recorded sea: velocities in the mirror",
        _SEA + "continued.py",
        "east[:, self.file.points :] *= -1.0",
        "east[:, self.file.points :] *= 1.0",
        _CONTINUED + "test_velocities_of_the_file_are_used_where_it_has_them",
    ),
    Plant(
        "recorded sea: velocities' potential",
        _SEA + "recorded.py",
        "(-1j * (k_east * east + k_north * north) / square)",
        "(1j * (k_east * east + k_north * north) / square)",
        _CONTINUED + "test_velocities_of_the_file_are_used_where_it_has_them",
    ),
    Plant(
        "recorded sea: level where it is not",
        _SEA + "continued.py",
        "return (x < west) | (x > east) | (y < south) | (y > north)",
        "return (x < west) | (x > east + 1.0) | (y < south) | (y > north)",
        _CONTINUED + "test_a_level_sea_is_level_and_begins_without_a_step",
    ),
    Plant(
        "recorded sea: what its rim fades is lost",
        _SEA + "continued.py",
        "return float(np.mean(self._fading**2)) ** 2",
        "return 1.0",
        _CONTINUED + "test_a_known_wave_comes_back",
    ),
    Plant(
        "recorded sea: its own mean is taken off each frame",
        _IO + "recorded_sea.py",
        "frame) - self.level_m",
        "frame) - np.nanmean(self._read(self.name, frame))",
        _CONTINUED + "test_waves_too_long_for_the_patch_are_told",
    ),
    Plant(
        "recorded sea: cells beyond it are judged",
        "seamap_rt/truth/ground.py",
        "np.all(sea.known",
        "np.any(sea.known",
        _CONTINUED + "test_nothing_beyond_is_judged",
    ),
    Plant(
        "recorded sea: ground cells beyond it are judged",
        "seamap_rt/truth/ground.py",
        ").all(axis=-1)",
        ").any(axis=-1)",
        _CONTINUED + "test_nothing_beyond_is_judged",
    ),
    Plant(
        "recorded sea: rings count what is not known",
        "seamap_rt/measured.py",
        "known.sum(axis=around).astype(np.float64)",
        "np.full(share.shape[-1], share.size / share.shape[-1])",
        _CONTINUED + "test_nothing_beyond_is_judged",
    ),
    Plant(
        "recorded sea: a gauge takes what is beyond",
        _SEA + "surface.py",
        "np.where(self.known(x, y), height, np.nan)",
        "height",
        _CONTINUED + "test_gauges_take_nothing_beyond",
    ),
    Plant(
        "recorded sea: a gap's bending across its corners",
        _IO + "gaps.py",
        "    ((0, 0, np.sqrt(2.0)), (0, 1, -np.sqrt(2.0)), (1, 0, -np.sqrt(2.0)), (1, 1, np.sqrt(2.0))),",
        "    ((0, 0, np.sqrt(2.0)), (0, 1, -np.sqrt(2.0)), (1, 0, np.sqrt(2.0)), (1, 1, -np.sqrt(2.0))),",
        _GAPS + "test_a_plane_goes_on_across_any_gap_and_over_an_edge",
    ),
    Plant(
        "recorded sea: a gap's stated error",
        _IO + "gaps.py",
        "np.cos(turn) + 0.5 * turn * np.sin(turn)",
        "np.cos(turn) + 0.25 * turn * np.sin(turn)",
        _GAPS + "test_a_wave_across_a_strip_errs_as_stated_and_across_a_disc_by_less",
    ),
    Plant(
        "recorded sea: a gap's width to the middles of its rim",
        _IO + "gaps.py",
        "distance_transform_edt(gap)).max()) + 0.5",
        "distance_transform_edt(gap)).max())",
        _GAPS + "test_half_a_width_is_counted_to_the_known_water",
    ),
    Plant(
        "recorded sea: wide gaps are filled too",
        _SEA + "recorded.py",
        "if gap > self._widest_gap:",
        "if gap > 10.0 * self._widest_gap:",
        _HOSTILE + "test_a_hostile_file_is_refused_in_a_line",
    ),
    Plant(
        "recorded sea: minutes of video",
        _IO + "stereo_bursts.py",
        'searchsorted(self._ends, number, side="right")',
        'searchsorted(self._ends, number, side="left")',
        _STEREO + "test_minutes_of_a_stereo_video_follow_each_other",
    ),
    Plant(
        "recorded sea: Matlab's axes in HDF5",
        _IO + "stereo_bursts.py",
        "found = tuple(reversed(_there(file, name, path).shape))",
        "found = tuple(_there(file, name, path).shape)",
        _STEREO + "test_minutes_of_a_stereo_video_follow_each_other",
    ),
    Plant(
        "recorded sea: times of single precision",
        _IO + "recorded_sea.py",
        "stray = max(_UNEVEN * abs(step), min(rounding, _ROUNDED * abs(step)))",
        "stray = _UNEVEN * abs(step)",
        _STEREO + "test_times_of_single_precision_are_even",
    ),
    Plant(
        "recorded sea: units of its frames",
        _IO + "recorded_sea.py",
        '_within(step, _STEPS_S, "s"',
        '_within(0.1, _STEPS_S, "s"',
        _HOSTILE + "test_a_hostile_file_is_refused_in_a_line",
    ),
)
