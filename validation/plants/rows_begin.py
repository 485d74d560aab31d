"""Plants in what a user meets first: scenes that are begun and refused, progress, folders, wrong data."""

from __future__ import annotations

from .plant import Plant

PLANTS = (
    Plant(
        "checks that rely on a failed one",
        "seamap_rt/scene/agreement.py",
        "if not failed.isdisjoint(check.relies_on):",
        "if False:",
        "tests/scene/test_scene.py::test_what_follows_from_another_problem_is_not_told_again",
    ),
    Plant(
        "only the first disagreement",
        "seamap_rt/scene/agreement.py",
        "told += refusal.problems if isinstance(refusal, InputError) else (str(refusal),)",
        "told = told or [str(refusal)]",
        "tests/scene/test_scene.py::test_all_that_sections_disagree_in_is_told",
    ),
    Plant(
        "a wrong key judged by its default",
        "seamap_rt/io/validation.py",
        "                    vars(part).pop(str(key), None)\n",
        "                    pass\n",
        "tests/scene/test_scene.py::test_a_check_that_needs_a_wrong_key_says_nothing_of_its_default",
    ),
    Plant(
        "a problem in two lines",
        "seamap_rt/errors.py",
        "dict.fromkeys(one_line(each) for each in (message, *more))",
        "dict.fromkeys((message, *more))",
        "tests/test_errors.py::test_several_problems_are_as_many_lines",
    ),
    Plant(
        "a scene begun with the first wave system alone",
        "seamap_rt/scene/starting.py",
        "tables = list(held) if section.many",
        "tables = list(held)[:1] if section.many",
        "tests/scene/test_starting.py::test_it_is_the_scene_that_it_is_like_under_its_own_name",
    ),
    Plant(
        "a number written shorter than it is",
        "seamap_rt/scene/starting.py",
        "        if float(text) == value:\n            return text\n",
        "        return text\n",
        "tests/scene/test_starting.py::test_a_number_keeps_its_bits",
    ),
    Plant(
        "the time left by the first turn too",
        "seamap_rt/session/pace.py",
        "warm = lasted[1:]",
        "warm = lasted[0:]",
        "tests/test_pace.py::test_equal_turns_are_told_exactly",
    ),
    Plant(
        "a store described as long as its arrays",
        "seamap_rt/io/echo_store.py",
        '            array["shape"][0] = pulses\n',
        "            pass\n",
        "tests/io/test_echo_store.py::test_anyone_may_open_it_plainly_also_while_it_grows",
    ),
    Plant(
        "results of another kind",
        "seamap_rt/io/results_folder.py",
        "        if names.isdisjoint(products):\n",
        "        if not names:\n",
        "tests/cli/test_cli_refusals.py::test_results_of_different_kinds_do_not_mix",
    ),
    Plant(
        "data of any kind",
        "seamap_rt/errors.py",
        "    if not isinstance(value, kinds):\n",
        "    if kinds is None:\n",
        "tests/test_wrong_data.py::test_wrong_data_is_refused_in_the_projects_words",
    ),
    Plant(
        "what is compared over all",
        "seamap_rt/metrics.py",
        'overall = by_range.pop("overall")',
        'overall = {**by_range.pop("overall"), "height_bias_m": None}',
        "tests/test_metrics.py::test_a_comparison_holds_what_metrics_json_holds",
    ),
)
