"""Plants in prediction: fit, errors, draws, windows, vessels and what judges them."""

from __future__ import annotations

from .plant import Plant

_HOME = "seamap_rt/prediction/"
_FIT = "tests/prediction/test_fit.py::"
_SEEN = "tests/prediction/test_forecast.py::"
_TURNS = "tests/prediction/test_predictor.py::"

PLANTS = (
    Plant(
        "prior twice in the fit",
        _HOME + "assimilation.py",
        "return [root * part for root, part in zip(roots, parts, strict=True)]",
        "return [root**2 * part for root, part in zip(roots, parts, strict=True)]",
        _FIT + "test_the_fit_is_the_conditional_mean",
    ),
    Plant(
        "weights without the observations' errors",
        _HOME + "assimilation.py",
        "variance = seen.std**2 + np.where(elevation, left, 0.0)",
        "variance = seen.std + np.where(elevation, left, 0.0)",
        _FIT + "test_the_fit_is_the_conditional_mean",
    ),
    Plant(
        "prior's density of one part of an amplitude",
        _HOME + "lattice.py",
        "scale=np.sqrt(density) * self.spacing",
        "scale=np.sqrt(0.5 * density) * self.spacing",
        _FIT + "test_errors_are_those_of_the_conditional_sea",
    ),
    Plant(
        "waves run backwards in the sums",
        _HOME + "wave_sum.py",
        "carrier = factor * np.exp(-1j * lattice.omega * self._time",
        "carrier = factor * np.exp(1j * lattice.omega * self._time",
        _FIT + "test_sums_are_those_of_the_waves",
    ),
    Plant(
        "currents believed at one standard error",
        _HOME + "drift.py",
        "float(change @ self._matrix @ change) < _SURE**2",
        "float(change @ self._matrix @ change) < 1.0",
        "tests/prediction/test_drift.py::test_a_current_within_some_of_its_errors_is_not_believed",
    ),
    Plant(
        "a wind sea below a swell runs as the swell does",
        _HOME + "spectrum.py",
        "edge = _TAIL_FROM * k[_last_peak(ring * k**2 * np.sqrt(k))]",
        "edge = _TAIL_FROM * k[int(np.argmax(ring * k**2 * np.sqrt(k)))]",
        "tests/wavefield/test_expected_spectrum.py::test_a_wind_sea_across_a_swell_keeps_its_own_way_and_size",
    ),
    Plant(
        "a tail that falls too slowly",
        _HOME + "spectrum.py",
        "ring = np.where(tail & ~seen, level * k**-4.0, ring)",
        "ring = np.where(tail & ~seen, level * k**-3.5, ring)",
        "tests/wavefield/test_expected_spectrum.py::test_waves_too_short_to_be_seen_run_with_the_wind_sea",
    ),
    Plant(
        "adjoint without the carrier's conjugate",
        _HOME + "terms.py",
        "made[i, j] = np.conj(carrier[i, j]) * total",
        "made[i, j] = carrier[i, j] * total",
        _FIT + "test_the_adjoint_is_one",
    ),
    Plant(
        "few places moved the other way",
        _HOME + "wave_sum.py",
        "self._shares(lattice, factor, seen, x[members], y[members])",
        "self._shares(lattice, factor, seen, seen.x, seen.y)",
        _FIT + "test_sums_at_moved_places_are_those_there",
    ),
    Plant(
        "zones told twice as well",
        _HOME + "zones.py",
        "return 0.5 * side**2 * told.reshape(side, side)",
        "return side**2 * told.reshape(side, side)",
        _FIT + "test_what_is_told_alike_everywhere_is_turned_back_by_each_wave",
    ),
    Plant(
        "zones not put together as they were taken apart",
        _HOME + "zones.py",
        "packets = np.sum(self.windows * _inverse(waves), axis=0)",
        "packets = np.sum(_inverse(waves), axis=0)",
        _FIT + "test_the_preconditioner_is_its_own_adjoint_and_positive",
    ),
    Plant(
        "a sample's phase",
        _HOME + "ensemble.py",
        "missed = root * (drawn - found[0]) * np.exp(1j * phase)",
        "missed = root * drawn * np.exp(1j * phase)",
        _FIT + "test_errors_are_those_of_the_conditional_sea",
    ),
    Plant(
        "seas that are seen without errors",
        _HOME + "ensemble.py",
        "+ (each.errors[number] * np.sqrt(each.batch.variance)).astype(np.float32)",
        "+ (0.0 * each.errors[number]).astype(np.float32)",
        _FIT + "test_errors_are_those_of_the_conditional_sea",
    ),
    Plant(
        "known for ever",
        _HOME + "field.py",
        "return away + fastest(self.spectrum) * lapse <= 2.0 * np.pi / self.lattices[0].spacing - self.reach",
        "return away + 0.0 * lapse <= 2.0 * np.pi / self.lattices[0].spacing",
        _SEEN + "test_what_is_far_ahead_is_not_known",
    ),
    Plant(
        "slope's sign",
        _HOME + "lattice.py",
        "return np.asarray(1j * along, np.complex128)",
        "return np.asarray(-1j * along, np.complex128)",
        _SEEN + "test_slopes_and_velocity_are_derivatives_of_elevation",
    ),
    Plant(
        "draws without what is open",
        _HOME + "field.py",
        "made.append(mean + of_samples + np.real(waves @ quantity.groups))",
        "made.append(mean + np.real(waves @ quantity.groups))",
        _SEEN + "test_draws_have_the_stated_error_and_hang_together",
    ),
    Plant(
        "draws of a vessel by themselves",
        _HOME + "field.py",
        "of_samples = kept * np.real((parts[0] + 1j * parts[1]) @ samples)",
        "of_samples = kept * np.real(stream.standard_normal(parts[0].shape) @ samples)",
        _SEEN + "test_draws_of_a_raft_are_those_of_its_water",
    ),
    Plant(
        "a boat that stays where it was",
        _HOME + "forecast.py",
        "way = x + toward[0] * speed_m_s * lead, y",
        "way = x + 0.0 * lead, y",
        _SEEN + "test_a_boat_under_way_meets_the_waves_where_it_then_is",
    ),
    Plant(
        "windows by any moment",
        _HOME + "windows.py",
        ".all(axis=-1)\n        for begin in lead",
        ".any(axis=-1)\n        for begin in lead",
        _SEEN + "test_windows_count_the_draws_in_which_all_limits_hold_throughout",
    ),
    Plant(
        "limits apart",
        _HOME + "windows.py",
        "inside = inside & (np.abs(drawn) < value)",
        "inside = np.abs(drawn) < value",
        _SEEN + "test_windows_count_the_draws_in_which_all_limits_hold_throughout",
    ),
    Plant(
        "highest trough",
        _HOME + "windows.py",
        "crest, moment = drawn.max(axis=-1), fine[drawn.argmax(axis=-1)]",
        "crest, moment = -drawn.min(axis=-1), fine[drawn.argmin(axis=-1)]",
        _SEEN + "test_the_highest_wave_is_told_with_its_time",
    ),
    Plant(
        "old turns kept",
        _HOME + "predictor.py",
        "self._fit.keep({t.number for t in self._turns})",
        "pass",
        _TURNS + "test_turns_that_are_too_old_are_dropped",
    ),
    Plant(
        "the time of a dark turn",
        _HOME + "predictor.py",
        'self._issued = float(polar["time"].max())',
        'self._issued = self._issued if not len(seen) else float(polar["time"].max())',
        _TURNS + "test_a_dark_turn_moves_the_time_on_and_knows_less",
    ),
    Plant(
        "a current the other way",
        _HOME + "fit.py",
        "change = -(batch.seen.time - middle) * slopes",
        "change = (batch.seen.time - middle) * slopes",
        "tests/prediction/test_drift.py::test_residuals_tell_the_current",
    ),
    Plant(
        "a current that is found and not used",
        _HOME + "predictor.py",
        "water = self._drift.water(water_of(polar.attrs))",
        "water = water_of(polar.attrs)",
        _TURNS + "test_a_current_that_was_told_wrong_is_put_right",
    ),
    Plant(
        "the sea that came where the boat was",
        "seamap_rt/forecast_errors.py",
        'run = forecast.attrs["speed_m_s"] * lead',
        "run = 0.0 * lead",
        "tests/test_forecast_errors.py::test_the_sea_that_came_is_taken_along_the_way",
    ),
    Plant(
        "errors over the forecast's own spread",
        "seamap_rt/forecast_errors.py",
        "sigma = float(np.std(truth[:, :, place]))",
        "sigma = float(np.std(mean[:, :, place]))",
        "tests/test_forecast_errors.py::test_errors_are_shares_of_the_sea_that_came",
    ),
    Plant(
        "persistence of the sea that came",
        "seamap_rt/forecast_errors.py",
        "kept_on = mean[:, :1, place] - was",
        "kept_on = mean[:, -1:, place] - was",
        "tests/test_forecast_errors.py::test_errors_are_shares_of_the_sea_that_came",
    ),
)
