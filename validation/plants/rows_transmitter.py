"""Plants in the transmitter, from its pulses' phases to what maps and inspections make of them."""

from __future__ import annotations

from .plant import Plant

_ECHOES = "tests/echoes/test_magnetron.py::"
_MAPS = "tests/interferometry/test_magnetron_maps.py::"

PLANTS = (
    Plant(
        "magnetron: receivers of one pulse",
        "seamap_rt/echoes/transmitting.py",
        "angle = phase[pulse] + rate",
        "angle = phase[pulse] * (1 + receiver) + rate",
        f"{_ECHOES}test_receivers_of_a_pulse_see_the_wavenumber_of_its_own_carrier",
    ),
    Plant(
        "magnetron: all directions alike",
        "seamap_rt/echoes/transmitting.py",
        "phase = 2.0 * np.pi * turns",
        "phase = np.pi * turns",
        f"{_ECHOES}test_each_pulse_starts_anywhere_for_all_gates_and_receivers_alike",
    ),
    Plant(
        "magnetron: a pulse's own numbers",
        "seamap_rt/echoes/transmitting.py",
        "key_of(keys[0], number[n])",
        "key_of(keys[0], n)",
        f"{_ECHOES}test_a_pulse_keeps_its_phase_whatever_else_is_sent",
    ),
    Plant(
        "magnetron: its carrier's wavenumber",
        "seamap_rt/echoes/transmitting.py",
        "rate = -2.0 * np.pi * self.carrier",
        "rate = 2.0 * np.pi * self.carrier",
        f"{_ECHOES}test_receivers_of_a_pulse_see_the_wavenumber_of_its_own_carrier",
    ),
    Plant(
        "magnetron: phases that turn with range",
        "seamap_rt/echoes/transmitting.py",
        "- np.linalg.norm(sea - middle, axis=-1)",
        "+ np.linalg.norm(sea - middle, axis=-1)",
        f"{_ECHOES}test_a_carrier_that_strays_does_not_turn_phases_with_range",
    ),
    Plant(
        "magnetron: measured phases",
        "seamap_rt/echoes/transmitting.py",
        "np.exp(-1j * self.measured)",
        "np.exp(1j * self.measured)",
        f"{_ECHOES}test_coherence_between_pulses_after_their_phases_are_taken_off",
    ),
    Plant(
        "magnetron: coherence that measured phases leave",
        "seamap_rt/radar/transmitter.py",
        "-(transmit_phase_error(radar) ** 2)",
        "-0.5 * (transmit_phase_error(radar) ** 2)",
        f"{_ECHOES}test_coherence_between_pulses_after_their_phases_are_taken_off",
    ),
    Plant(
        "magnetron: velocities of random phases",
        "seamap_rt/interferometry/retrieval.py",
        "    if not looks.radar.coherent:\n        return {}",
        "    if looks.radar.coherent is None:\n        return {}",
        f"{_MAPS}test_heights_of_single_pulses_are_those_of_a_coherent_transmitter",
    ),
    Plant(
        "magnetron: each antenna on itself",
        "seamap_rt/interferometry/covariance/dwell_sums.py",
        'settings.paths == "best" and radar.coherent',
        'settings.paths == "best"',
        f"{_MAPS}test_switched_magnetrons_are_compared_one_way_alone",
    ),
    Plant(
        "magnetron: error of a look as a whole",
        "seamap_rt/interferometry/retrieval.py",
        "np.sqrt(2.0 / max(1, given.dwelt.pulses))",
        "np.sqrt(1.0 / max(1, given.dwelt.pulses))",
        f"{_MAPS}test_what_measured_phases_cost_alternating_pulses",
    ),
    Plant(
        "magnetron: alternating pulses refused",
        "seamap_rt/scene/checks/radar.py",
        "asked is None or pulse_coherence(radar) > 0.0",
        "asked is None or pulse_coherence(radar) >= 0.0",
        f"{_MAPS}test_a_scene_asks_nothing_of_phases_that_it_does_not_keep",
    ),
    Plant(
        "magnetron: height by its carrier",
        "seamap_rt/radar/precision.py",
        "jitter / radar.frequency_hz / np.sqrt(",
        "jitter / radar.frequency_hz / (",
        "tests/report/test_limits.py::test_what_a_magnetron_costs_is_said",
    ),
    Plant(
        "magnetron: pulses that are said to be coherent",
        "seamap_rt/inspection/transmitter.py",
        "np.abs(np.mean(runs[0] / np.abs(runs[0]), axis=1)) ** 2",
        "np.mean(np.abs(runs[0] / np.abs(runs[0])), axis=1) ** 2",
        "tests/inspection/test_inspection.py::test_pulses_that_are_said_to_be_coherent_and_are_not",
    ),
    Plant(
        "magnetron: errors of measured phases in degrees",
        "seamap_rt/inspection/transmitter.py",
        "np.degrees(np.sqrt(-np.log(kept)))",
        "np.degrees(-np.log(kept))",
        "tests/inspection/test_inspection.py::test_errors_of_measured_phases_are_told_in_degrees",
    ),
    Plant(
        "magnetron: the way that the next turn shows",
        "seamap_rt/inspection/motion.py",
        "comes_from = waves if totals[0] > totals[1]",
        "comes_from = waves if totals[0] < totals[1]",
        "tests/inspection/test_inspection.py::test_the_next_turn_tells_the_way_where_no_velocity_does",
    ),
)
