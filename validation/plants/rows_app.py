"""Errors planted in the page: who may ask it, what it reads while a run goes on, what its form says."""

from __future__ import annotations

from .plant import Plant

PLANTS = (
    Plant(
        "a page of another origin is let in",
        "seamap_rt/app/safety.py",
        "if origin is not None and urlsplit(origin)",
        "if origin is None and urlsplit(str(origin))",
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
)
