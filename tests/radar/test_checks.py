"""What a radar, a boat and their files cannot be: each refusal is one line, and the remedy it names works."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.errors import InputError
from seamap_rt.radar.array import antenna_array
from seamap_rt.scene import Scene, load_scene
from seamap_rt.settings import ObjectSettings, PlacedAntenna, PlatformSettings, SensorSettings

CHIRP = {"radar.waveform": "chirp", "radar.pulse_width_s": 3e-7}
DIGITAL = {"radar.receiver.chain": "digital"}
ALTERNATING = {"radar.interferogram": "alternating_pulse"}
BUOY = {"mesh": "buoy.stl", "position_m": [30.0, 0.0, 0.0]}


def listed(*roles: str, **more: Any) -> dict[str, Any]:
    """Antennas 20 cm over each other."""
    return {"radar.antennas": [{"offset_m": [0.0, 0.0, 0.2 * n], "role": role} for n, role in enumerate(roles)], **more}


def refusal(overrides: dict[str, Any]) -> str:
    with pytest.raises(InputError) as caught:
        load_scene("flat", overrides)
    line = str(caught.value)
    assert line.isprintable()
    return line


# ------------------------------------------------------------------------------------------- refusals and remedies

REFUSED: list[tuple[dict[str, Any], list[str], dict[str, Any]]] = [
    # overrides, what the line must hold, remedy typed in
    (
        {"radar.prf_hz": 60_000.0, "radar.range_m": [15.0, 3000.0], "tracing.facet_m": 4.0},
        ["radar.prf_hz = 60000: ", "at most 49960 ", "radar.range_m = 3000", "after the next pulse", "lower it"],
        {"radar.prf_hz": 49_960.0},
    ),
    (
        {**CHIRP, "radar.pulse_width_s": 1e-4, "radar.range_m": [15.0, 400.0]},
        ["radar.pulse_width_s = 0.0001: ", "less than 1/radar.prf_hz = 0.0001", "shorten it or lower radar.prf_hz"],
        {"radar.pulse_width_s": 2e-6},
    ),
    (
        {"radar.prf_hz": 300.0},
        ["retrieval.cell_azimuth_deg = 1.8: ", "holds 1.5 pulses and needs 2", "radar.prf_hz to 400"],
        {"radar.prf_hz": 400.0},
    ),
    (
        {"radar.prf_hz": 300.0, "radar.transmit": "single"},
        ["retrieval.cell_azimuth_deg = 1.8: ", "holds 1.5 pulses and needs 2", "radar.rotation_rpm to 45"],
        {"radar.rotation_rpm": 45.0},
    ),
    (
        {"radar.prf_hz": 600.0, **ALTERNATING},
        ["retrieval.cell_azimuth_deg = 1.8: must be at least 2.4 ", "holds 3 pulses and needs 4"],
        {"retrieval.cell_azimuth_deg": 2.4},
    ),
    (
        {"radar.prf_hz": 600.0, **ALTERNATING, "radar.transmit": "single"},
        ["retrieval.cell_azimuth_deg = 1.8: ", "holds 3 pulses and needs 4", "radar.prf_hz to 800"],
        {"radar.prf_hz": 800.0},
    ),
    (
        {"radar.scan": "staring", "radar.stare_s": 1e-3, "radar.prf_hz": 1500.0},
        ["radar.stare_s = 0.001: ", "at least 0.001334 ", "1.5 pulses and needs 2", "radar.prf_hz to 2000"],
        {"radar.stare_s": 1.334e-3},
    ),
    (
        {"radar.scan": "staring", "radar.stare_s": 1e-3, "radar.prf_hz": 3500.0, **ALTERNATING},
        ["radar.stare_s = 0.001: ", "3.5 pulses and needs 4", "radar.prf_hz to 4000"],
        {"radar.prf_hz": 4000.0},
    ),
    (
        {"radar.range_m": [15.0, 17.9]},
        ["radar.range_m = [15,17.9]: ", "at least 3 long", "raise its far end"],
        {"radar.range_m": [15.0, 18.0]},
    ),
    (
        {**CHIRP, "radar.pulse_width_s": 1.0007e-6, "radar.range_m": [15.0, 150.0]},
        ["radar.range_m = [15,150]: ", "wholly nearer than 150.1 m", "raise its far end"],
        {"radar.range_m": [15.0, 150.1]},
    ),
    (
        {**CHIRP, "radar.pulse_width_s": 1e-8},
        ["radar.chirp_bandwidth_hz = 5e+07: ", "at least 1/radar.pulse_width_s = 1e+08", "radar.waveform = 'pulse'"],
        {"radar.waveform": "pulse"},
    ),
    (
        {**CHIRP, "radar.range_sampling_m": 2.9},
        ["radar.range_sampling_m = 2.9: ", "at most 2.398 m apart", "Nyquist"],
        {"radar.range_sampling_m": 2.398},
    ),
    (
        {**CHIRP, **DIGITAL},
        ["radar.receiver.chain = 'digital': ", "plain pulse", "choose 'baseband'"],
        {"radar.receiver.chain": "baseband"},
    ),
    (
        {**DIGITAL, "radar.receiver.if_hz": 190e6},
        ["radar.receiver.if_hz = 1.9e+08: ", "Nyquist zone, 100 MHz to 200 MHz", "choose 125 MHz to 175 MHz"],
        {"radar.receiver.if_hz": 175e6},
    ),
    (
        {**DIGITAL, "radar.receiver.adc_rate_hz": 80e6, "radar.receiver.if_hz": 75e6},
        ["radar.receiver.if_hz = 7.5e+07: ", "adc_rate_hz to at least 100 MHz"],
        {"radar.receiver.adc_rate_hz": 100e6},
    ),
    (
        {**DIGITAL, "radar.receiver.adc_bits": 0},
        ["radar.receiver.adc_bits = 0: ", "at least 1 "],
        {"radar.receiver.adc_bits": 1},
    ),
    (
        {**DIGITAL, "radar.receiver.adc_bits": 25},
        ["radar.receiver.adc_bits = 25: ", "at most 24 "],
        {"radar.receiver.adc_bits": 24},
    ),
    (
        listed("both", "tx"),
        ["radar.antennas: 1 receive and 2 transmit", "at least two must receive"],
        listed("both", "both"),
    ),
    (
        listed("rx", "rx"),
        ["radar.antennas: 2 receive and 0 transmit", "one transmit"],
        listed("both", "rx"),
    ),
    (
        {"radar.antennas": [{"offset_m": [0.0, 0.1, 0.3]}, {"offset_m": [0.0, 0.1, 0.3]}]},
        ["radar.antennas: ", "0 and 1 receive at the same place", "move one by its offset_m"],
        {"radar.antennas": [{"offset_m": [0.0, 0.1, 0.3]}, {"offset_m": [0.0, 0.1, 0.31]}]},
    ),
    (
        # Not only the first two: retrieval.receivers may ask for any.
        {"radar.antennas": [{"offset_m": [0.0, 0.0, z]} for z in (0.1, 0.3, 0.1)], "retrieval.receivers": [0, 2]},
        ["radar.antennas: ", "0 and 2 receive at the same place"],
        {"radar.antennas": [{"offset_m": [0.0, 0.0, z]} for z in (0.1, 0.3, 0.2)]},
    ),
    (
        listed("both", "both", "both", **ALTERNATING),
        ["radar.interferogram = 'alternating_pulse': ", "two receivers in turn, and here are 3", "single_pulse"],
        {"radar.interferogram": "single_pulse"},
    ),
    (
        # The third would never be sampled.
        listed("both", "both", "rx", **ALTERNATING),
        ["radar.interferogram = 'alternating_pulse': ", "two receivers in turn, and here are 3", "leave two"],
        listed("both", "both"),
    ),
    (
        listed("both", "rx", **ALTERNATING),
        ["radar.interferogram = 'alternating_pulse': ", "both", "radar.transmit = 'single'"],
        {"radar.transmit": "single"},
    ),
    (
        listed("both", "both", **{"radar.baseline_error_m": 0.01}),
        ["radar.baseline_error_m = 0.01: ", "must be 0 beside radar.antennas"],
        {"radar.baseline_error_m": 0.0},
    ),
    (
        listed("both", "both", **{"radar.channel_phase_deg": 5.0}),
        ["radar.channel_phase_deg = 5: ", "must be 0 beside radar.antennas"],
        {"radar.channel_phase_deg": 0.0},
    ),
    (
        listed("both", "both", **{"radar.channel_gain_db": 5.0}),
        ["radar.channel_gain_db = 5: ", "must be 0 beside radar.antennas"],
        {"radar.channel_gain_db": 0.0},
    ),
    (
        {"retrieval.receivers": [0, 2]},
        ["retrieval.receivers = [0, 2]: ", "two different ones of the 2 receivers", "0 to 1"],
        {"retrieval.receivers": [1, 0]},
    ),
    (
        {"retrieval.receivers": [1, 1]},
        ["retrieval.receivers = [1, 1]: ", "two different"],
        listed("tx", "rx", "rx", "rx", **{"retrieval.receivers": [0, 2]}),
    ),
    (
        {"radar.antennas": [{"offset_m": [0.0, 0.0, z]} for z in (-6.0, 0.1)]},
        ["radar.height_m = 5: ", "greater than 6 ", "the lowest of radar.antennas", "under water"],
        {"radar.height_m": 6.01},
    ),
    (
        {"platform.motion": "file", "platform.file": "motion.csv", "platform.speed_m_s": 3.0},
        ["platform", "speed_m_s", "must be 0 with motion = 'file'"],
        {"platform.motion": "fixed", "platform.file": None},
    ),
    (
        {"platform.motion": "file", "platform.file": "motion.csv", "platform.trim_deg": 3.0},
        ["platform", "trim_deg", "must be 0 with motion = 'file'"],
        {"platform.motion": "fixed", "platform.file": None},
    ),
    (
        {"platform.roll_deg": 5.0},
        ["platform", "roll_deg = 5: ", "unless motion = 'sinusoidal'", "list_deg"],
        {"platform.motion": "sinusoidal"},
    ),
    (
        {"platform.motion": "wave_following", "platform.heave_m": 1.0},
        ["platform", "heave_m = 1: ", "unless motion = 'sinusoidal'"],
        {"platform.heave_m": 0.0},
    ),
    (
        {"platform.motion": "file"},
        ["platform", "motion = 'file' and file = '…' together"],
        {"platform.motion": "fixed"},
    ),
    (
        {"radar.antenna.pattern": "file"},
        ["radar.antenna", "pattern = 'file' and file = '…' together"],
        {"radar.antenna.pattern": "gaussian"},
    ),
]


@pytest.mark.parametrize(("overrides", "fragments", "remedy"), REFUSED, ids=lambda each: None)
def test_a_refusal_is_one_line_and_its_remedy_works(
    overrides: dict[str, Any],
    fragments: list[str],
    remedy: dict[str, Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    line = refusal(overrides)
    for fragment in fragments:
        assert fragment in line, line
    assert line.startswith(fragments[0])
    load_scene("flat", {**overrides, **remedy})


def test_the_unambiguous_range_is_half_the_way_of_light_between_pulses() -> None:
    """The next digit up from the limit that is named is refused already."""
    keys = {"radar.range_m": [15.0, 3000.0], "tracing.facet_m": 4.0}
    assert SPEED_OF_LIGHT / (2.0 * 49_960.0) > 3000.0 > SPEED_OF_LIGHT / (2.0 * 49_970.0)
    load_scene("flat", {**keys, "radar.prf_hz": 49_960.0})
    assert "radar.prf_hz = 49970: " in refusal({**keys, "radar.prf_hz": 49_970.0})


@pytest.mark.parametrize("bits", [1, 24])
def test_any_converter_of_1_to_24_bits_is_taken(bits: int) -> None:
    assert load_scene("flat", {**DIGITAL, "radar.receiver.adc_bits": bits}).radar.receiver.adc_bits == bits


def test_a_tilt_lifts_or_sinks_what_stands_off_the_arrays_origin() -> None:
    """An antenna 4 m ahead of the array's origin goes down by 4 sin 60° = 3.465 m; behind it, up."""
    ahead, behind = ({"radar.antennas": [{"offset_m": [0.0, y, 0.0]}, {"offset_m": [0.0, 0.0, 0.2]}],
                      "radar.tilt_deg": 60.0, "radar.height_m": 3.4} for y in (4.0, -4.0))  # fmt: skip
    line = refusal(ahead)
    assert line.startswith("radar.height_m = 3.4: must be greater than 3.465 ")
    load_scene("flat", {**ahead, "radar.height_m": 3.466})
    load_scene("flat", behind)


# ---------------------------------------------------------------------------------------------------------- its files


def motion_file(path: Path, times: Any, roll: Any = None) -> Path:
    times = np.asarray(times, dtype=np.float64)
    roll = np.sin(times) if roll is None else roll
    rows = [f"{time:.3f},{angle:.4f}" for time, angle in zip(times, roll, strict=True)]
    path.write_text("time_s,roll_deg\n" + "\n".join(rows) + "\n", encoding="utf-8")
    return path


def recorded(path: Path) -> dict[str, Any]:
    return {"platform.motion": "file", "platform.file": str(path), "turns": 5}


@pytest.mark.parametrize(
    ("times", "words"),
    [
        (np.concatenate((np.arange(0.0, 2.0, 0.1), np.arange(4.0, 8.0, 0.1))), ["a gap of 2.1 s", "fill it"]),
        (np.concatenate((np.arange(0.0, 4.0, 0.1), np.arange(3.0, 8.0, 0.1))), ["line 42", "time_s = 3", "sort"]),
        (np.arange(0.0, 3.0, 0.1), ["time 5.0", "0 to 2.9 s", "longer record"]),
        ([0.0], ["1 readings", "at least 2"]),
    ],
)
def test_a_motion_of_no_use_is_refused_when_the_scene_is_read(tmp_path: Path, times: Any, words: list[str]) -> None:
    file = motion_file(tmp_path / "motion.csv", times)
    line = refusal(recorded(file))
    assert line.startswith(f"file '{file}'")
    for word in words:
        assert word in line, line


def test_a_motion_with_holes_in_its_numbers_is_refused(tmp_path: Path) -> None:
    times = np.arange(0.0, 8.0, 0.1)
    roll = np.sin(times)
    roll[17] = np.nan
    line = refusal(recorded(motion_file(tmp_path / "motion.csv", times, roll)))
    assert "line 19: roll_deg = 'nan': must be a finite number" in line


def test_a_motion_that_is_there_and_long_enough_is_taken(tmp_path: Path) -> None:
    file = motion_file(tmp_path / "motion.csv", np.arange(0.0, 5.6, 0.1))
    assert load_scene("flat", recorded(file)).platform.file == str(file)


@pytest.mark.parametrize(
    ("overrides", "start"),
    [
        ({"platform.motion": "file", "platform.file": "no.csv"}, "file '{folder}/no.csv': no such file; "),
        (
            {"radar.antenna.pattern": "file", "radar.antenna.file": "no.msi"},
            "radar.antenna.file = '{folder}/no.msi': no such file; ",
        ),
        (
            {
                "radar.antennas": [
                    {"offset_m": [0.0] * 3},
                    {"offset_m": [0.0, 0.0, 0.2], "pattern": "file", "file": "x"},
                ]
            },
            "radar.antennas.1.file = '{folder}/x': no such file; ",
        ),
        ({"objects": [BUOY]}, "objects.0.mesh = '{folder}/buoy.stl': no such file; "),
    ],
)
def test_a_file_that_is_not_there_is_named(
    overrides: dict[str, Any], start: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By its whole path; those of overrides count from the working folder."""
    monkeypatch.chdir(tmp_path)
    assert refusal(overrides).startswith(start.format(folder=tmp_path))


def pattern_file(path: Path) -> Path:
    angle = np.arange(-90.0, 91.0)
    rows = [f"{cut},{a:g},{-12.0 * (a / width) ** 2:.6f}" for cut, width in (("azimuth", 2.0), ("elevation", 18.0))
            for a in (np.linspace(-10.0, 10.0, 201) if cut == "azimuth" else angle)]  # fmt: skip
    path.write_text("cut,angle_deg,gain_db\n" + "\n".join(rows) + "\n", encoding="utf-8")
    return path


SCENE = """
name = "all_of_it"
turns = 2

[radar]
waveform = "chirp"
pulse_width_s = 2e-7
compression_window = "taylor"
range_sampling_m = 1.2
range_m = [15.0, 150.0]
sector_deg = [-20.0, 40.0]
height_m = 6.0
tilt_deg = 3.0

[radar.antenna]
pattern = "file"
file = "data/pattern.csv"

[[radar.antennas]]
offset_m = [0.0, 0.0, -0.1]

[[radar.antennas]]
offset_m = [0.0, 0.01, 0.1]
offset_error_m = [0.0, 0.0, 0.001]
role = "rx"
bandwidth_hz = 8e7
channel_gain_db = 0.5
channel_phase_deg = -3.0

[radar.receiver]
adc_bits = 14
gain = "agc"

[platform]
motion = "file"
file = "data/motion.csv"
lever_arm_m = [0.5, -1.0, 5.0]

[platform.sensors]
roll_bias_deg = 0.1
rate_hz = 50.0

[[objects]]
mesh = "data/buoy.stl"
position_m = [20.0, 30.0, 0.0]
rcs_dbsm = 3.0

[[objects]]
mesh = "data/buoy.stl"
position_m = [0.0, -2.0, 1.0]
fixed_to = "boat"
scale = 0.5

[retrieval]
receivers = [1, 0]
pulse_pairs = "forward"
"""


@pytest.fixture
def everything(tmp_path: Path) -> Path:
    """A scene file with all sections, and its files in a folder beside it."""
    (tmp_path / "data").mkdir()
    pattern_file(tmp_path / "data" / "pattern.csv")
    motion_file(tmp_path / "data" / "motion.csv", np.arange(-0.5, 3.0, 0.05))
    (tmp_path / "data" / "buoy.stl").write_bytes(b"solid")
    file = tmp_path / "everything.toml"
    file.write_text(SCENE, encoding="utf-8")
    return file


def test_files_count_from_the_scene_files_folder(
    everything: Path, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path_factory.mktemp("elsewhere"))
    scene, data = load_scene(everything), everything.parent / "data"
    assert scene.radar.antenna.file == str(data / "pattern.csv")
    assert [placed.file for placed in scene.radar.antennas] == [str(data / "pattern.csv")] * 2
    assert scene.platform.file == str(data / "motion.csv")
    assert [each.mesh for each in scene.objects] == [str(data / "buoy.stl")] * 2
    assert antenna_array(scene.radar).beam_deg == pytest.approx(2.0, rel=0.01)  # −12 dB (a/2)²: −3 dB at 1°


def test_a_scene_of_all_sections_reads_back_equal(everything: Path, tmp_path: Path) -> None:
    scene = load_scene(everything)
    assert scene.radar.antennas[1] == PlacedAntenna(
        offset_m=(0.0, 0.01, 0.1),
        offset_error_m=(0.0, 0.0, 0.001),
        role="rx",
        bandwidth_hz=8e7,
        channel_gain_db=0.5,
        channel_phase_deg=-3.0,
        pattern="file",
        file=str(everything.parent / "data" / "pattern.csv"),
    )
    assert isinstance(scene.objects[0], ObjectSettings)
    assert scene.objects[1].fixed_to == "boat"
    assert scene.platform == PlatformSettings(
        motion="file",
        file=str(everything.parent / "data" / "motion.csv"),
        lever_arm_m=(0.5, -1.0, 5.0),
        sensors=SensorSettings(roll_bias_deg=0.1, rate_hz=50.0),
    )
    (tmp_path / "away").mkdir()
    written = tmp_path / "away" / "resolved.toml"
    written.write_text(scene.to_toml(), encoding="utf-8")
    again: Scene = load_scene(written)
    assert again == scene
    assert hash(again) == hash(scene)
    assert again.to_toml() == scene.to_toml()


def test_perfect_sensors_are_written_and_read_too(tmp_path: Path) -> None:
    """Their rate is infinite, which TOML can say."""
    scene = load_scene("tiny")
    assert np.isinf(scene.platform.sensors.rate_hz)
    file = tmp_path / "scene.toml"
    file.write_text(scene.to_toml(), encoding="utf-8")
    assert load_scene(file) == scene
