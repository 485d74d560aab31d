"""Plants in the nonlinear sea and its record."""

from __future__ import annotations

from .plant import Plant

_SEA = "seamap_rt/sea/"
_HIGH_ORDER = "tests/sea/test_high_order.py::"

PLANTS = (
    Plant(
        "nonlinear sea: order of the squares",
        _SEA + "high_order/rates.py",
        "steep * _squares(rise, self.order - 2)",
        "steep * _squares(rise, self.order - 1)",
        _HIGH_ORDER + "test_rates_are_those_of_an_energy",
    ),
    Plant(
        "nonlinear sea: aliases",
        _SEA + "high_order/rates.py",
        "fast_size((self.order + 1) * self.band.most_x + 1)",
        "fast_size(2 * self.band.most_x + 1)",
        _HIGH_ORDER + "test_rates_are_those_of_an_energy",
    ),
    Plant(
        "nonlinear sea: the surface carried along",
        _SEA + "high_order/rates.py",
        "start=-slope_flow",
        "start=slope_flow",
        _HIGH_ORDER + "test_what_is_missing_falls_by_the_order",
    ),
    Plant(
        "nonlinear sea: potential at the mean level",
        _SEA + "high_order/rates.py",
        "powers.append(powers[-1] * powers[1] / n)",
        "powers.append(powers[-1] * powers[1])",
        _HIGH_ORDER + "test_what_is_missing_falls_by_the_order",
    ),
    Plant(
        "nonlinear sea: second order",
        _SEA + "high_order/rates.py",
        "potential_rate *= 0.5",
        "potential_rate *= 0.51",
        _HIGH_ORDER + "test_two_crossing_waves_bind_what_second_order_theory_says",
    ),
    Plant(
        "nonlinear sea: depth",
        _SEA + "high_order/basin.py",
        "k * np.tanh(k * self.depth)",
        "k * np.tanh(k * self.depth) ** 2",
        _HIGH_ORDER + "test_order_one_is_the_linear_sea",
    ),
    Plant(
        "nonlinear sea: Runge and Kutta's weights",
        _SEA + "high_order/evolution.py",
        "a + 2.0 * (b + c)",
        "a + 2.0 * b + 2.02 * c - 0.02 * a",
        _HIGH_ORDER + "test_steps_are_of_fourth_order",
    ),
    Plant(
        "nonlinear sea: the slow beginning",
        _SEA + "high_order/evolution.py",
        "RELAXING_POWER = 4",
        "RELAXING_POWER = 1",
        _HIGH_ORDER + "test_a_slow_beginning_sheds_no_free_waves",
    ),
    Plant(
        "nonlinear sea: what breaking took",
        _SEA + "high_order/evolution.py",
        "broken=state.broken + lost",
        "broken=state.broken + 0.5 * lost",
        _HIGH_ORDER + "test_breaking_takes_energy_and_is_all_that_does",
    ),
    Plant(
        "nonlinear sea: the current in the record",
        "seamap_rt/products/recorded_sea.py",
        "carried = np.exp(-1j",
        "carried = np.exp(1j",
        "tests/products/test_recorded_sea.py::test_order_one_is_the_runs_linear_sea",
    ),
    Plant(
        "nonlinear sea: the state of a killed record",
        "seamap_rt/products/recorded_progress.py",
        "elevation=state.elevation,\n            potential",
        'elevation=state.elevation.astype("complex64"),\n            potential',
        "tests/products/test_recorded_sea.py::test_killed_it_goes_on_with_the_same_bits",
    ),
    Plant(
        "nonlinear sea: linear waves' potential",
        _SEA + "high_order/linear_start.py",
        "-1j * speed * (ahead - behind)",
        "1j * speed * (ahead - behind)",
        _HIGH_ORDER + "test_order_one_is_the_linear_sea",
    ),
    Plant(
        "nonlinear sea: W at the surface",
        _SEA + "high_order/rates.py",
        "self.band.to_waves(sum(rise[2:], start=rise[1])) + highest",
        "self.band.to_waves(sum(rise[2:], start=rise[1])) + 0.9 * highest",
        _HIGH_ORDER + "test_the_vertical_velocity_errs_as_published",
    ),
    Plant(
        "nonlinear sea: action",
        _SEA + "high_order/rates.py",
        "steep * sum(rise[2 : self.order - 1], start=rise[1])",
        "0.9 * steep * sum(rise[2 : self.order - 1], start=rise[1])",
        _HIGH_ORDER + "test_a_slow_beginning_keeps_the_action",
    ),
    Plant(
        "nonlinear sea: third harmonics",
        _SEA + "high_order/rates.py",
        "powers.append(powers[-1] * powers[1] / n)",
        "powers.append(0.5 * powers[-1] * powers[1] / n)",
        _HIGH_ORDER + "test_harmonics_peak_a_narrow_sea",
    ),
    Plant(
        "nonlinear sea: breaking three tenths slower",
        _SEA + "high_order/breaking.py",
        "np.exp(-self.rate * step",
        "np.exp(-0.7 * self.rate * step",
        _HIGH_ORDER + "test_the_filter_is_the_published_one_sixty_four_times_a_period",
    ),
    Plant(
        "nonlinear sea: a softer filter",
        _SEA + "high_order/breaking.py",
        "SHARPNESS = 30.0",
        "SHARPNESS = 20.0",
        _HIGH_ORDER + "test_the_filter_is_the_published_one_sixty_four_times_a_period",
    ),
    Plant(
        "nonlinear sea: what is broken",
        _SEA + "high_order/evolution.py",
        "(state.elevation - 0.5 * gone[0])",
        "(state.elevation - 0.35 * gone[0])",
        _HIGH_ORDER + "test_what_is_broken_of_low_waves_is_the_energy_that_is_gone",
    ),
    Plant(
        "nonlinear sea: a record too early",
        _SEA + "high_order/plan.py",
        "BEFORE = 1.6",
        "BEFORE = 1.1",
        _HIGH_ORDER + "test_a_record_begins_when_the_nonlinear_rates_act",
    ),
    Plant(
        "nonlinear sea: steps twice as long",
        _SEA + "high_order/plan.py",
        "_STEPS_A_PERIOD = 30.0",
        "_STEPS_A_PERIOD = 15.0",
        _HIGH_ORDER + "test_steps_follow_the_waves",
    ),
)
