"""Plants in what is worked out on the device."""

from __future__ import annotations

from .plant import Plant

_SUM, _TURN = "seamap_rt/echoes/summation/device.py", "seamap_rt/echoes/turn_on_device.py"
_MESH, _RETURNS = "seamap_rt/mesh/on_device.py", "seamap_rt/echoes/returns_on_device.py"
_BATCHES, _TURNS = "tests/echoes/test_summation.py", "tests/echoes/test_turn_on_device.py"
_DWELLS, _SUMS = "seamap_rt/interferometry/covariance/dwells_on_device.py", "tests/interferometry/test_dwell_sums.py"
_WINDOWS, _SPLINES = (
    "seamap_rt/interferometry/covariance/windows_on_device.py",
    "seamap_rt/sea/spline_on_device.py",
)
_WINDOWED = "tests/interferometry/test_window_kernel.py::test_windows_are_what_they_say"
_SAME_SPLINES = "tests/sea/test_moving_field.py::test_the_device_has_the_same_splines"
_RECEIVERS = "seamap_rt/echoes/receiving_on_device.py"
_ALIKE = _TURNS + "::test_a_turn_is_the_processors"
_FACETS = _TURNS + "::test_facets_there_are_those_of_the_host"
_CROSSES = _TURNS + "::test_from_ray_to_map_only_cells_come_back"

PLANTS = (
    Plant(
        "a graphics processor draws the next facet's numbers",
        "seamap_rt/echoes/summation/gaussian_on_device.py",
        "of.UInt64(number) + of.UInt64(1)",
        "of.UInt64(number) + of.UInt64(2)",
        _BATCHES + "::test_sums_by_the_law",
    ),
    Plant(
        "a graphics processor leaves out the last facet near a gate",
        _SUM,
        "return begin, np.maximum(begin, end)",
        "return begin, np.maximum(begin, end - (end > begin))",
        _BATCHES + "::test_sums_by_the_law",
    ),
    Plant(
        "device: phases in float32",
        _SUM,
        "cycles = (2.0 * range_m + longer + rate * middle) * -per_metre",
        "cycles = of.Float64(of.Float((2.0 * range_m + longer + rate * middle) * -per_metre))",
        _ALIKE,
    ),
    Plant(
        "device: steps of paths that are alike",
        _SUM,
        "most = ALIKE / (2.0 * np.pi * batch.window)",
        "most = 100.0 * ALIKE / (2.0 * np.pi * batch.window)",
        _ALIKE,
    ),
    Plant(
        "device: facets that a gate cannot hear",
        _TURN,
        "margin = support_m(batch) + ",
        "margin = 0.5 * support_m(batch) + ",
        _ALIKE,
    ),
    Plant(
        "device: a path that one antenna lights",
        _TURN,
        "dr.select(lit[i] & lit[j],",
        "dr.select(lit[i] | lit[j],",
        _ALIKE,
    ),
    Plant(
        "device: cross-sections by way of the host",
        _TURN,
        "dr.gather(of.Float, self.returns.rcs, place)",
        "dr.gather(of.Float, of.place(of.fetch(self.returns.rcs, (-1,))), place)",
        _CROSSES,
    ),
    Plant(
        "device: the radial edge of the other line",
        _MESH,
        "own, line = rung + odd, column + 1 - odd",
        "own, line = rung + odd, column + odd",
        _FACETS,
    ),
    Plant(
        "device: light on vertices as they are",
        _MESH,
        "(rung > 0) & (rung < rungs - 1)) / 12.0",
        "(rung > 0) & (rung < rungs - 1)) / 24.0",
        _FACETS,
    ),
    Plant(
        "device: the other antenna's light",
        "seamap_rt/tracing/rays.py",
        "place = (antenna * shape[1] + column)",
        "place = ((shape[0] - 1 - antenna) * shape[1] + column)",
        _TURNS + "::test_rays_whose_answers_stay_there_light_the_same_facets",
    ),
    Plant(
        "device: incidence from below",
        _RETURNS,
        "_RIGHT_ANGLE - dr.atan(",
        "_RIGHT_ANGLE + dr.atan(",
        _ALIKE,
    ),
    Plant(
        "device: breakers that run the other way",
        _RETURNS,
        "outward = look + dr.gather(of.Float, speed, column)",
        "outward = look - dr.gather(of.Float, speed, column)",
        _TURNS + "::test_how_fast_facets_are_is_known_from_two_numbers",
    ),
    Plant(
        "device: Gauss's distribution",
        "seamap_rt/compute/functions.py",
        "dr.erf(value * float(np.sqrt(0.5)))",
        "dr.erf(value)",
        _ALIKE,
    ),
    Plant(
        "device: bins that change their shares",
        "seamap_rt/truth/on_device.py",
        "dr.select(first == own, 1.0 - share,",
        "dr.select(first == own, share,",
        _ALIKE,
    ),
    Plant(
        "device: water that does not bend",
        "seamap_rt/truth/on_device.py",
        "mesh.height(column, facet) - of.Float64(bend)",
        "mesh.height(column, facet)",
        _ALIKE,
    ),
    Plant(
        "device: a pulse between the next nodes",
        _RECEIVERS,
        "(1 - taps // 2 - nodes.first)",
        "(2 - taps // 2 - nodes.first)",
        _ALIKE,
    ),
    Plant(
        "device: the other receiver's noise",
        _RECEIVERS,
        "cell % receivers)",
        "receivers - 1 - cell % receivers)",
        _ALIKE,
    ),
    Plant(
        "device: noise before its filter",
        _RECEIVERS,
        "place = dr.gather(of.Float, table, tap), begin + tap",
        "place = dr.gather(of.Float, table, tap), begin",
        _ALIKE,
    ),
    Plant(
        "device: a channel's phase backwards",
        _RECEIVERS,
        "real * a - imag * b, real * b + imag * a",
        "real * a + imag * b, imag * a - real * b",
        _ALIKE,
    ),
    Plant(
        "device: a receiver that is not sampled",
        _RECEIVERS,
        "dr.select(heard, of.Float(0.0), of.Float(np.nan))",
        "dr.select(heard, of.Float(0.0), of.Float(0.0))",
        _ALIKE,
    ),
    Plant(
        "device: the batches' nodes",
        _TURN,
        "within = node - low",
        "within = node - low - 1",
        _ALIKE,
    ),
    Plant(
        "device: products of the other sense",
        _DWELLS,
        "a * c + b * d, b * c - a * d",
        "a * c + b * d, a * d - b * c",
        _SUMS + "::test_every_sum_is_what_it_says_it_is",
    ),
    Plant(
        "device: levels of one factor alone",
        _DWELLS,
        "cosine, sine = p * r - q * s, p * s + q * r",
        "cosine, sine = p, q",
        _SUMS + "::test_every_sum_is_what_it_says_it_is",
    ),
    Plant(
        "device: the neighbouring gate's dwell",
        _DWELLS,
        "owner * columns + column) == own",
        "owner * columns) == own",
        _SUMS + "::test_every_sum_is_what_it_says_it_is",
    ),
    Plant(
        "device: a dwell's last product",
        _DWELLS,
        "np.maximum.at(end, low[within] + beyond, within + 1)",
        "np.maximum.at(end, low[within] + beyond, within)",
        _SUMS + "::test_every_sum_is_what_it_says_it_is",
    ),
    Plant(
        "device: covariance by way of the host",
        "seamap_rt/interferometry/looks.py",
        'isinstance(voltage := echoes["voltage"].data, ComplexOnDevice)',
        'isinstance(voltage := echoes["voltage"].data, str)',
        _CROSSES,
    ),
    Plant(
        "device: echoes by way of the host",
        "seamap_rt/dataset.py",
        "there = isinstance(value, ComplexOnDevice)",
        "there = isinstance(value, str)",
        _CROSSES,
    ),
    Plant(
        "device: windows that turn the other way",
        _WINDOWS,
        "dr.sincos(-(of.Float(m) * along",
        "dr.sincos((of.Float(m) * along",
        _WINDOWED,
    ),
    Plant(
        "device: windows of one side alone",
        _WINDOWS,
        "both = beside & opposite",
        "both = beside",
        _WINDOWED,
    ),
    Plant(
        "device: a window's level at its own cell",
        _WINDOWS,
        "dr.gather(of.Float, each, place, both) for each in level[2:]",
        "dr.gather(of.Float, each, lane, both) for each in level[2:]",
        _WINDOWED,
    ),
    Plant(
        "device: dwells go up for each window",
        "seamap_rt/interferometry/covariance/windows.py",
        "    @cached_property\n    def _cells_there",
        "    @property\n    def _cells_there",
        "tests/interferometry/test_window_kernel.py::test_dwells_go_to_the_device_once_and_windows_come_back",
    ),
    Plant(
        "device: windows by way of the host",
        _DWELLS,
        "there=True",
        "there=False",
        _SUMS + "::test_of_voltages_on_the_device_cells_come_back_alone",
    ),
    Plant(
        "device: splines begin a row too far",
        _SPLINES,
        "whole - ((taps - 1) // 2 + origin)",
        "whole - (taps // 2 + origin)",
        _SAME_SPLINES,
    ),
    Plant(
        "device: splines of the neighbouring time step",
        "seamap_rt/sea/moving_field.py",
        "first = np.searchsorted(numbers, interval + self.taps[0])",
        "first = np.searchsorted(numbers, np.maximum(interval - 1, interval.min()) + self.taps[0])",
        _SAME_SPLINES,
    ),
    Plant(
        "device: splines' steps in float32",
        _SPLINES,
        "steps = position * per_metre",
        "steps = of.Float64(of.Float(position * per_metre))",
        _SAME_SPLINES,
    ),
    Plant(
        "device: knots go up each time",
        "seamap_rt/sea/moving_field.py",
        "self._placed = kept | ",
        "self._placed = ",
        _SAME_SPLINES,
    ),
    Plant(
        "device: the sea stays where it was asked to go",
        "seamap_rt/compute/placement.py",
        'return word == "device" or (not word and',
        'return word == "device" or (bool(word) and',
        "tests/sea/test_moving_field.py::test_the_sea_goes_to_a_graphics_processor_with_the_echoes",
    ),
    Plant(
        "device: arrays that share the host's memory",
        "seamap_rt/compute/device.py",
        "dr.JitBackend.LLVM or not values.size:",
        "dr.JitBackend.LLVM or values.size:",
        "tests/test_device.py::test_what_is_placed_is_a_copy",
    ),
    Plant(
        "device: voltages that come here each time",
        "seamap_rt/compute/complex_on_device.py",
        "    @cached_property\n    def here",
        "    @property\n    def here",
        "tests/test_device.py::test_complex_numbers_there_are_an_array_and_come_here_once",
    ),
)
