"""Which antenna sends, which hear, over which paths; where they stand, and how unlike beams stand to each other."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from seamap_rt.radar.array import antenna_array, common_squint_deg, squint_deg, with_scanned_sector
from seamap_rt.settings import RadarSettings

TWO = ("both", "both")


def radar_of(roles: tuple[str, ...] = (), transmit: str = "switched", interferogram: str = "single_pulse", **keys: Any):
    """A radar with an antenna of each role, 20 cm over each other; with none, the two of [radar] itself."""
    antennas = [{"offset_m": [0.0, 0.0, 0.2 * n], "role": role} for n, role in enumerate(roles)]
    return RadarSettings.model_validate(
        {"transmit": transmit, "interferogram": interferogram, "antennas": antennas, **keys}
    )


def cycle(radar: RadarSettings) -> list[tuple[int, tuple[int, ...]]]:
    """(transmitter, antennas that hear it) of each pulse in turn."""
    array = antenna_array(radar)
    return [(slot.transmitter, tuple(array.receivers[r] for r in slot.receivers)) for slot in array.cycle]


# ------------------------------------------------------------------------------------------------------------- modes

CYCLES = [
    (TWO, "single", "single_pulse", [(0, (0, 1))]),
    (TWO, "switched", "single_pulse", [(0, (0, 1)), (1, (0, 1))]),
    (TWO, "single", "alternating_pulse", [(0, (0,)), (0, (1,))]),
    (TWO, "switched", "alternating_pulse", [(0, (0,)), (1, (1,))]),
    (("rx", "both"), "single", "single_pulse", [(1, (0, 1))]),
    (("rx", "both"), "switched", "single_pulse", [(1, (0, 1))]),
    (("rx", "both"), "single", "alternating_pulse", [(1, (0,)), (1, (1,))]),
    (("rx", "tx", "rx"), "single", "single_pulse", [(1, (0, 2))]),
    (("rx", "tx", "rx"), "switched", "single_pulse", [(1, (0, 2))]),
    (("both", "tx", "both"), "switched", "single_pulse", [(0, (0, 2)), (1, (0, 2)), (2, (0, 2))]),
    (("both", "tx", "both"), "switched", "alternating_pulse", [(0, (0,)), (2, (2,))]),
    (("both", "tx", "both"), "single", "alternating_pulse", [(0, (0,)), (0, (2,))]),
    (("both", "both", "rx"), "switched", "single_pulse", [(0, (0, 1, 2)), (1, (0, 1, 2))]),
    (("both",) * 3, "single", "single_pulse", [(0, (0, 1, 2))]),
    (("both",) * 4, "switched", "single_pulse", [(n, (0, 1, 2, 3)) for n in range(4)]),
    (("tx", "rx", "rx", "tx"), "switched", "single_pulse", [(0, (1, 2)), (3, (1, 2))]),
    (("tx", "rx", "rx", "tx"), "single", "alternating_pulse", [(0, (1,)), (0, (2,))]),
]


@pytest.mark.parametrize(("roles", "transmit", "interferogram", "expected"), CYCLES)
def test_the_cycle_is_that_of_the_table(roles: tuple[str, ...], transmit: str, interferogram: str, expected: Any):
    radar = radar_of(roles, transmit, interferogram)
    array = antenna_array(radar)
    assert cycle(radar) == expected
    assert array.transmitters == tuple(dict.fromkeys(sender for sender, _ in expected))
    assert array.whole == (interferogram == "single_pulse")
    assert array.phase_paths == (2 if (transmit, interferogram) == ("switched", "alternating_pulse") else 1)
    assert [element.transmits for element in array.elements] == [role != "rx" for role in roles]
    assert [element.receives for element in array.elements] == [role != "tx" for role in roles]


@pytest.mark.parametrize(("transmit", "interferogram", "expected"), [each[1:] for each in CYCLES[:4]])
def test_the_short_form_is_two_that_do_both(transmit: str, interferogram: str, expected: Any) -> None:
    assert cycle(radar_of((), transmit, interferogram)) == expected


@pytest.mark.parametrize(("roles", "transmit", "interferogram", "expected"), CYCLES)
def test_a_path_serves_both_ways_and_is_there_once(roles: tuple[str, ...], transmit: str, interferogram: str, expected):
    array = antenna_array(radar_of(roles, transmit, interferogram))
    assert set(array.paths) == {(min(t, a), max(t, a)) for t, heard in expected for a in heard}
    assert list(array.paths) == sorted(set(array.paths))
    for slot in array.cycle:
        for receiver in slot.receivers:
            pair = {slot.transmitter, array.receivers[receiver]}
            assert set(array.paths[array.path(slot.transmitter, receiver)]) == pair


def test_switched_pairs_need_three_sums_and_not_four() -> None:
    array = antenna_array(radar_of(TWO))
    assert array.paths == ((0, 0), (0, 1), (1, 1))
    assert array.path(0, 1) == array.path(1, 0) == 1
    assert len(antenna_array(radar_of(("both",) * 4)).paths) == 10


@pytest.mark.parametrize(
    ("roles", "transmit", "interferogram", "words"),
    [
        (("both", "tx"), "single", "single_pulse", ["1 receive and 2 transmit", "at least two must receive"]),
        (("rx", "rx"), "single", "single_pulse", ["2 receive and 0 transmit", "one transmit", "role"]),
        (("both",), "switched", "single_pulse", ["1 receive and 1 transmit"]),
        (("both", "rx"), "switched", "alternating_pulse", ["alternating_pulse", "both", "radar.transmit = 'single'"]),
    ],
)
def test_a_mode_that_the_antennas_cannot_serve_is_refused(
    roles: tuple[str, ...], transmit: str, interferogram: str, words: list[str]
) -> None:
    with pytest.raises(ValueError, match=r"^radar\.") as refusal:
        antenna_array(radar_of(roles, transmit, interferogram))
    for word in words:
        assert word in str(refusal.value)
    assert "\n" not in str(refusal.value)


# ----------------------------------------------------------------------------------------------------- where they are


def test_the_two_of_the_short_form_stand_half_a_baseline_below_and_above() -> None:
    array = antenna_array(radar_of(baseline_m=0.6, baseline_error_m=0.01, channel_gain_db=6.0, channel_phase_deg=90.0))
    assert_allclose(array.known_offsets, [[0.0, 0.0, -0.3], [0.0, 0.0, 0.3]], rtol=1e-15)
    assert_allclose(array.offsets, [[0.0, 0.0, -0.305], [0.0, 0.0, 0.305]], rtol=1e-15)  # the error is the true one's
    assert array.baseline_m == pytest.approx(0.6, rel=1e-15)  # what the retrieval is told
    assert array.elements[0].channel == 1.0
    assert_allclose(array.elements[1].channel, 1j * 10.0**0.3, rtol=1e-15)
    assert all(np.isinf(element.bandwidth_hz) for element in array.elements)


def test_each_listed_antenna_has_its_own_place_error_channel_and_bandwidth() -> None:
    radar = RadarSettings.model_validate(
        {
            "antennas": [
                {"offset_m": [0.3, -0.1, 0.0], "offset_error_m": [0.0, 0.02, -0.01], "role": "tx"},
                {"offset_m": [0.0, 0.0, 0.0], "channel_gain_db": -3.0},
                {"offset_m": [0.0, 0.3, 0.4], "channel_phase_deg": -60.0, "bandwidth_hz": 30e6, "role": "rx"},
            ]
        }
    )
    array = antenna_array(radar)
    assert_allclose(array.known_offsets, [[0.3, -0.1, 0.0], [0.0, 0.0, 0.0], [0.0, 0.3, 0.4]], rtol=1e-15)
    assert_allclose(array.offsets - array.known_offsets, [[0.0, 0.02, -0.01], [0.0] * 3, [0.0] * 3], atol=1e-16)
    assert array.receivers == (1, 2)
    assert array.baseline_m == pytest.approx(0.5, rel=1e-15)  # between the first two that receive
    assert_allclose(array.elements[1].channel, 10.0**-0.15, rtol=1e-15)
    assert_allclose(array.elements[2].channel, 0.5 - 0.5j * np.sqrt(3.0), rtol=1e-14)
    assert [element.bandwidth_hz for element in array.elements] == [np.inf, np.inf, 30e6]


def test_antennas_are_like_the_common_one_but_for_what_they_say() -> None:
    radar = RadarSettings.model_validate(
        {
            "antenna": {"pattern": "gaussian", "azimuth_beamwidth_deg": 2.0},
            "antennas": [{"offset_m": [0.0, 0.0, 0.0]}, {"offset_m": [0.0, 0.0, 0.2], "azimuth_beamwidth_deg": 2.5}],
        }
    )
    array = antenna_array(radar)
    widths = [element.antenna.azimuth_beamwidth_deg for element in array.elements]
    assert_allclose(widths, (2.0, 2.5), rtol=1e-9)  # root finding
    assert array.beam_deg == pytest.approx(2.5, rel=1e-9)
    assert array.narrowest_beam_deg == pytest.approx(2.0, rel=1e-9)


# ------------------------------------------------------------------------------------------------------------- squint


def end_fed(frequency: float, *feeds: str, **keys: Any) -> RadarSettings:
    antennas = [{"offset_m": [0.0, 0.0, 0.2 * n], "feed": feed} for n, feed in enumerate(feeds)]
    common = {"feed": "end", "design_frequency_hz": 10e9, "pattern": "gaussian"}
    return RadarSettings.model_validate({"frequency_hz": frequency, "antenna": common, "antennas": antennas, **keys})


@pytest.mark.parametrize("frequency", [9.8e9, 10.15e9])
def test_squint_turns_the_sector_that_is_seen(frequency: float) -> None:
    """Above the design frequency the beam lies clockwise of the aperture's normal; the turntable's time is its own."""
    radar = end_fed(frequency, sector_deg=[30.0, 90.0])
    squint = squint_deg(radar.antenna, frequency)
    assert np.sign(squint) == np.sign(frequency - 10e9)
    seen = with_scanned_sector(radar)
    assert_allclose(seen.sector_deg, (30.0 + squint, 90.0 + squint), rtol=1e-15)
    assert seen.model_copy(update={"sector_deg": radar.sector_deg}) == radar


def test_without_squint_the_radar_is_left_as_it_is() -> None:
    radar = end_fed(10e9)
    assert with_scanned_sector(radar) is radar
    assert common_squint_deg(RadarSettings()) == 0.0


@pytest.mark.parametrize("frequency", [9.8e9, 10.15e9])
def test_alike_squints_leave_the_cuts_on_the_boresight(frequency: float) -> None:
    for radar in (end_fed(frequency), end_fed(frequency, "end", "end")):
        for element in antenna_array(radar).elements:
            assert peak_deg(element.antenna) == pytest.approx(0.0, abs=1e-6)


def peak_deg(antenna: Any) -> float:
    """Middle of the −10 dB points: clockwise positive. Bisection to 1e-9 deg or better."""
    ends = []
    angle = np.linspace(-20.0, 20.0, 40_001)
    level = np.abs(antenna.azimuth(np.sin(np.radians(angle))))
    for step in (1, -1):
        above = np.flatnonzero(level[::step] >= np.sqrt(0.1))[0]
        first, second = angle[::step][above - 1], angle[::step][above]
        for _ in range(40):
            middle = 0.5 * (first + second)
            if np.abs(antenna.azimuth(np.sin(np.radians(np.array([middle]))))[0]) >= np.sqrt(0.1):
                second = middle
            else:
                first = middle
        ends.append(second)
    return 0.5 * sum(ends)


@pytest.mark.parametrize("frequency", [9.8e9, 10.15e9])
def test_unlike_squints_shift_one_cut_against_the_other(frequency: float) -> None:
    """The boresight is the first one's beam: one fed in the middle stands off it by the squint, to the other side."""
    for feeds, sign in ((("end", "centre"), -1.0), (("centre", "end"), 1.0)):
        radar = end_fed(frequency, *feeds)
        squint = squint_deg(radar.antenna, frequency)
        assert abs(squint) > 0.5
        assert common_squint_deg(radar) == (squint if feeds[0] == "end" else 0.0)
        first, second = (peak_deg(element.antenna) for element in antenna_array(radar).elements)
        assert first == pytest.approx(0.0, abs=1e-6)
        # A shift in direction cosine: of the −10 dB points, 1.6° off, the one moves 1e-4 less than the other.
        assert second == pytest.approx(sign * squint, abs=2e-3)


def test_the_array_is_made_once() -> None:
    assert antenna_array(RadarSettings()) is antenna_array(RadarSettings())
    first = antenna_array(end_fed(9.8e9, "end", "centre"))
    assert_array_equal(first.offsets, antenna_array(end_fed(9.8e9, "end", "centre")).offsets)
