"""Plants in the sea spikes."""

from __future__ import annotations

from .plant import Plant

_SPIKES = "seamap_rt/scattering/sea_spikes.py"
_KERNEL, _FIELD = "seamap_rt/echoes/spike_kernel.py", "seamap_rt/echoes/spike_field.py"
_PAPER, _DRAWS = "tests/scattering/test_sea_spikes.py", "tests/echoes/test_spike_field.py"

PLANTS = (
    Plant(
        "spikes' shape",
        _SPIKES,
        "BURST_SQUARE = 1.2",
        "BURST_SQUARE = 1.5",
        _DRAWS + "::test_the_spread_is_that_of_the_closed_form",
    ),
    Plant(
        "spikes' crest",
        _SPIKES,
        "CREST_LENGTH = 0.1 ",
        "CREST_LENGTH = 0.4 ",
        _PAPER + "::test_the_closed_form_gives_the_law_of_watts_and_wicks",
    ),
    Plant(
        "spikes' life",
        _SPIKES,
        "LIFE_PERIODS * 2.0 * np.pi",
        "LIFE_PERIODS * np.pi",
        _PAPER + "::test_lengths_lives_and_speeds_are_those_of_their_waves",
    ),
    Plant(
        "spikes' fastest wave",
        _SPIKES,
        "LEAST_WIND = 1.68",
        "LEAST_WIND = 0.84",
        _PAPER + "::test_lengths_lives_and_speeds_are_those_of_their_waves",
    ),
    Plant(
        "spikes' ways",
        _SPIKES,
        "tables.append(np.interp(probability, rising / rising[-1], angle))",
        "tables.append(np.interp(probability, rising / rising[-1], 0.5 * angle))",
        _PAPER + "::test_they_are_the_breaking_sea_cut_into_pieces",
    ),
    Plant(
        "spikes' number",
        _SPIKES,
        "return self.fraction * self.share / self.zone_m2",
        "return 1.1 * self.fraction * self.share / self.zone_m2",
        _DRAWS + "::test_the_mean_is_one_at_every_range_and_look",
    ),
    Plant(
        "spikes' growth",
        _KERNEL,
        "light = breed.brightness * 6.0 * grown",
        "light = breed.brightness * 5.0 * grown",
        _DRAWS + "::test_the_mean_is_one_at_every_range_and_look",
    ),
    Plant(
        "spikes on the wrong triangle",
        _KERNEL,
        ">= across)",
        "< across)",
        _DRAWS + "::test_each_lies_in_its_own_triangle",
    ),
    Plant(
        "spikes' lives all alike",
        _KERNEL,
        "-breed.scale * math.log(1.0 - _CUT * uniform(own, 1))",
        "breed.scale",
        _DRAWS + "::test_they_are_remembered_for_as_long_as_they_live",
    ),
    Plant(
        "spikes run against the wind",
        _FIELD,
        "self.wind_from_deg + 180.0",
        "self.wind_from_deg",
        _DRAWS + "::test_who_runs_with_them_sees_them_stand",
    ),
    Plant(
        "spikes on a still current",
        _KERNEL,
        "east + (breaker.run_east + breed.drift_east) * past - sweep.origin_east[column]",
        "east + breaker.run_east * past - sweep.origin_east[column]",
        _DRAWS + "::test_a_current_carries_them",
    ),
    Plant(
        "spikes' speed inward",
        _KERNEL,
        "light * (breaker.run_east * x + breaker.run_north * y)",
        "-light * (breaker.run_east * x + breaker.run_north * y)",
        _DRAWS + "::test_their_echo_moves_as_the_mean_of_their_waves",
    ),
    Plant(
        "spikes of each turn anew",
        _FIELD,
        "Stream.SPIKES), number)",
        "Stream.SPIKES, grid.turn), number)",
        _DRAWS + "::test_turns_and_sectors_share_their_bits",
    ),
    Plant(
        "spikes' cells of time",
        _KERNEL,
        "math.floor(begin / breed.slot) - 1",
        "math.floor(begin / breed.slot)",
        _DRAWS + "::test_the_mean_is_one_at_every_range_and_look",
    ),
    Plant(
        "spikes at a circle's seam",
        _KERNEL,
        "for lap in range(-1, (columns",
        "for lap in range(0, (columns",
        _DRAWS + "::test_where_a_sector_begins_it_has_what_the_circle_has",
    ),
    Plant(
        "spikes in the expectation",
        "seamap_rt/simulation.py",
        "    if not spikes:\n",
        "    if False:\n",
        _DRAWS + "::test_the_surface_takes_them_and_the_expectation_does_not",
    ),
    Plant(
        "spikes' own speed",
        "seamap_rt/echoes/radar_cross_section.py",
        "lit.speed - motion.breaker_speed",
        "lit.speed + motion.breaker_speed",
        _DRAWS + "::test_the_surface_takes_them_and_the_expectation_does_not",
    ),
    Plant(
        "breakers' places: speed of a crest",
        "validation/scattering/breaking_places.py",
        "weight * rate_bend * bend) / (",
        "0.5 * weight * rate_bend * bend) / (",
        "tests/sea/test_breaking_places.py::test_on_one_wave_the_water_runs_at_ka_of_the_crest",
    ),
)
