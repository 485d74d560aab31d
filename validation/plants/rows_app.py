"""Errors planted in the page: who may ask it, what it reads while a run goes on, what its form says."""

from __future__ import annotations

from .plant import Plant

PLANTS = (
    Plant(
        "a page of another origin is let in",
        "seamap_rt/app/safety.py",
        'if origin is not None and origin.partition("://")',
        'if origin is None and str(origin).partition("://")',
        "tests/app/test_safety.py::test_anything_else_is_refused",
    ),
    Plant(
        "a token is known by its beginning",
        "seamap_rt/app/safety.py",
        "any(hmac.compare_digest(each.encode(), self.token.encode()) for each in told)",
        "any(self.token.startswith(each) for each in told)",
        "tests/app/test_safety.py::test_anything_else_is_refused",
    ),
    Plant(
        "links lead out of the page's folders",
        "seamap_rt/app/safety.py",
        "real = Path(path).resolve()",
        "real = Path(path).absolute()",
        "tests/app/test_safety.py::test_only_what_lies_below_the_folders_is_held",
    ),
    Plant(
        "a body is not counted as it comes",
        "seamap_rt/app/safety.py",
        'self._seen += len(message.get("body", b""))',
        'self._seen = len(message.get("body", b""))',
        "tests/app/test_safety.py::test_a_body_is_bounded_by_what_it_says_and_by_what_it_sends",
    ),
    Plant(
        "a growing file is read without its journal",
        "seamap_rt/io/growing_file.py",
        "page = self._pages.get(number)",
        "page = None",
        "tests/io/test_growing_file.py::test_pages_of_a_commit_that_are_not_in_the_file_yet_are_read_from_its_journal",
    ),
    Plant(
        "a cycle of phase is worth half the height",
        "seamap_rt/app/prospects.py",
        "ambiguity_m=2.0 * np.pi * per_radian",
        "ambiguity_m=np.pi * per_radian",
        "tests/app/test_prospects.py::test_a_cycle_of_phase_is_worth_height_as_lambda_r_over_p_b",
    ),
    Plant(
        "gigahertz are read as megahertz",
        "seamap_rt/app/words.py",
        '    "frequency_hz": ("GHz", "1e9")',
        '    "frequency_hz": ("GHz", "1e6")',
        "tests/app/test_draft.py::test_people_read_and_write_frequencies_in_gigahertz",
    ),
    Plant(
        "the time left counts the cold first turn",
        "seamap_rt/app/progress.py",
        "each = (starts[-1][1] - starts[1][1]) / (len(starts) - 2)",
        "each = (starts[-1][1] - starts[0][1]) / (len(starts) - 1)",
        "tests/app/test_jobs.py::test_the_time_left_is_that_of_the_turns_left_at_the_pace_of_the_warm_ones",
    ),
    Plant(
        "persistence keeps what came, not what was known",
        "seamap_rt/app/what_came.py",
        '("persistence", mean[:, :1] - true)',
        '("persistence", true[:, :1] - true)',
        "tests/app/test_what_came.py::test_the_sea_is_the_runs_own_and_an_offset_is_found_as_such",
    ),
    Plant(
        "a map's spectrum counts each wave as often as its lattice does",
        "seamap_rt/app/map_spectrum.py",
        "return (2.0 * np.pi / step) ** 2 / float(",
        "return 1.0 + 0.0 * float(",
        "tests/app/test_map_spectrum.py::test_a_wave_keeps_its_variance_its_frequency_and_its_direction",
    ),
    Plant(
        "from the mast one sees through crests",
        "seamap_rt/app/sea_light.py",
        "horizon = np.maximum.accumulate(rising, axis=0)",
        "horizon = np.sort(rising, axis=0)",
        "tests/app/test_sea_light.py::test_a_crest_hides_what_lies_behind_it_as_far_as_its_ray_reaches",
    ),
    Plant(
        "the sun shines from below",
        "seamap_rt/app/sea_light.py",
        "cosine = (to_sun[2] - rise_x * to_sun[0] - rise_y * to_sun[1])",
        "cosine = (to_sun[2] + rise_x * to_sun[0] + rise_y * to_sun[1])",
        "tests/app/test_sea_light.py::test_a_slope_towards_the_sun_is_brightest_and_one_away_from_it_has_the_skys_share_alone",
    ),
    Plant(
        "an upload is written over another of its name",
        "seamap_rt/app/uploads.py",
        'with path.open("xb") as file:',
        'with path.open("wb") as file:',
        "tests/app/test_uploads.py::test_a_file_of_the_same_name_is_never_written_over",
    ),
    Plant(
        "what its reader refuses stays among the uploads",
        "seamap_rt/app/uploads.py",
        "path.unlink(missing_ok=True)",
        "path.exists()",
        "tests/app/test_uploads.py::test_any_bytes_are_a_file_or_a_line",
    ),
    Plant(
        "what checks an upload has all the machine's memory",
        "seamap_rt/app/checking.py",
        "resource.setrlimit(resource.RLIMIT_AS, (_MOST_MEMORY, _MOST_MEMORY))",
        "pass",
        "tests/app/test_uploads.py::test_the_process_that_checks_has_bounded_memory_and_says_a_line",
    ),
    Plant(
        "a trade's point is run with the first seed",
        "seamap_rt/app/trade_point.py",
        '{**point.keys, "seed": point.seed}',
        "{**point.keys}",
        "tests/app/test_folders.py::test_a_point_is_run_with_the_scene_and_the_seed_that_the_trade_gave_it",
    ),
)
