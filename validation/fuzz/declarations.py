"""Files that declare their units and conventions, of which what is right is known: each is read right, or refused in
one line that names a word of its declaration; a unit of another kind is never read.

python -m validation.fuzz.declarations [--cases 3000] [--seed 1] [--case READER/NUMBER]

The sizes of units stand here once more, written down by hand, and nothing of the program's own table is asked.
"""

from __future__ import annotations

import random
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from seamap_rt.errors import InputError
from seamap_rt.interferometry import open_recording
from seamap_rt.io.patternfile import read_pattern
from seamap_rt.io.recorded_sea import recorded_sea
from seamap_rt.io.spectrumfile import read_directional_spectrum
from seamap_rt.prediction import read_capytaine

from ..options import options
from .originals import HEADER

PI = np.pi
LENGTHS = {"m": 1.0, "metres": 1.0, "meter": 1.0, "cm": 0.01, "mm": 1e-3, "km": 1e3, "ft": 0.3048, "Metres": 1.0}
TIMES = {"s": 1.0, "seconds": 1.0, "sec": 1.0, "ms": 1e-3, "milliseconds": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9,
         "min": 60.0}  # fmt: skip
ANGLES = {"degree": 1.0, "degrees": 1.0, "deg": 1.0, "degr": 1.0, "°": 1.0, "rad": 180 / PI, "radian": 180 / PI,
          "radians": 180 / PI}  # fmt: skip
HERTZ = {"Hz": 1.0, "hertz": 1.0, "s-1": 1.0, "1/s": 1.0, "s^-1": 1.0, "s**-1": 1.0, "mHz": 1e-3,
         "rad/s": 0.5 / PI, "rad s-1": 0.5 / PI, "radian/s": 0.5 / PI, "rad s^{-1}": 0.5 / PI}  # fmt: skip
RATES = {"rad/s": 1.0, "rad s-1": 1.0, "radians/s": 1.0, "Hz": 2 * PI}
AREAS = {"m2": 1.0, "m^2": 1.0, "m**2": 1.0, "m²": 1.0, "m^{2}": 1.0, "cm2": 1e-4, "100 m2": 100.0,
         "J/m2": 1 / (1025 * 9.81), "J m-2": 1 / (1025 * 9.81), "kJ m^-2": 1e3 / (1025 * 9.81)}  # fmt: skip
PER_HERTZ = {"{}/Hz": 1.0, "{} Hz-1": 1.0, "{} s": 1.0, "{}*s": 1.0, "{}/(rad/s)": 2 * PI, "{} s/rad": 2 * PI}
PER_ANGLE = {"{}/degree": 1.0, "{}/degr": 1.0, "{} deg-1": 1.0, "{} degree^{{-1}}": 1.0, "{}/rad": PI / 180,
             "{} rad-1": PI / 180, "{} radian**-1": PI / 180}  # fmt: skip
NO_UNITS = ("kg", "lux", "furlong", "gon", "dB", "log10(m)", "m2/Hz", "K", "1", "m/degrees", "m s s m-7", "??", "m/")
SENSES = (  # words, by which attribute, and by how much the directions of the file are turned
    ("", "", 0.0), ("standard_name", "sea_surface_wave_from_direction", 0.0),
    ("standard_name", "sea_surface_wave_to_direction", 180.0), ("long_name", "direction waves propagate to", 180.0),
    ("comment", "coming from, clockwise from true north", 0.0), ("convention", "oceanographic", 180.0),
    ("long_name", "direction from which waves come", 0.0), ("description", "nautical", 0.0),
)  # fmt: skip
HEIGHT, FROM = 2.0, 300.0
_HZ, _FROM = np.arange(0.05, 0.405, 0.01), np.arange(0.0, 360.0, 10.0)


@dataclass
class Case:
    """What a file declares, and what is right. known: all of it can be obeyed."""

    dice: random.Random
    folder: Path
    words: list[str] = field(default_factory=list)
    known: bool = True

    def unit(self, table: dict[str, float]) -> tuple[dict[str, str], float]:
        """An attribute, and the size of the unit; now and then none, or one of another kind."""
        luck = self.dice.random()
        if luck < 0.2:
            return {}, 1.0
        if luck < 0.25:
            self.known = False
            self.words.append(self.dice.choice([each for each in NO_UNITS if each not in table]))
            return {"units": self.words[-1]}, 1.0
        unit = self.dice.choice(list(table))
        self.words.append(unit)
        return {"units": unit}, table[unit]


Judge = Callable[[], tuple[NDArray[np.float64], NDArray[np.float64]]]  # reads; what came, and what is right


def _table() -> NDArray[np.float64]:
    """m²/(Hz·degree) of HEIGHT from FROM."""
    table = (_HZ**-5.0 * np.exp(-1.25 * (0.125 / _HZ) ** 4))[:, None] * np.cos(np.radians(_FROM - FROM) / 2.0) ** 40
    return table * (HEIGHT / 4.0) ** 2 / np.trapezoid(10.0 * table.sum(axis=1), _HZ)


def _as_read(path: Path) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    read = read_directional_spectrum(path)
    energy = read.density.sum(axis=1) * 360.0 / read.from_deg.size
    wave = read.density.sum(axis=0) @ np.exp(1j * np.radians(read.from_deg))
    peak = read.frequency_hz[np.argmax(energy)]
    height = 4.0 * np.sqrt(np.trapezoid(energy, read.frequency_hz))
    return np.array([height, peak, np.degrees(np.angle(wave)) % 360.0]), np.array(
        [HEIGHT, _HZ[np.argmax(_table().sum(axis=1))], FROM]
    )


def spectrum_netcdf(case: Case) -> Judge:
    dice = case.dice
    layout = dice.choice(["wavespectra", "ww3", "ncswan"])
    efth, freq, direction, sense, per_rad, rad = {
        "wavespectra": ("efth", "freq", "dir", 0.0, False, False),
        "ww3": ("efth", "frequency", "direction", 180.0, True, False),
        "ncswan": ("density", "frequency", "direction", 0.0, True, True),
    }[layout]
    hertz, hertz_size = case.unit(HERTZ)
    angle, degrees = case.unit(ANGLES)
    degrees = degrees if angle or not rad else 180 / PI
    key, words, turn = dice.choice(SENSES)
    turn = turn if key else sense
    known, said = case.known, list(case.words)
    density, size = case.unit({"": 1.0})
    if case.known is known and density:
        (area, one), (per_f, two), (per_d, three) = (
            dice.choice(list(each.items())) for each in (AREAS, PER_HERTZ, PER_ANGLE)
        )
        text = per_d.format(per_f.format(area))
        density, size = {"units": text}, one * two * three
        case.words = [*said, text]
    elif not density:
        size = PI / 180 if per_rad else 1.0
    action = bool(density) and case.known and dice.random() < 0.1
    values = _table() / size
    told: dict[str, Any] = {"long_name": "wave action density"} if action else {}
    if action:
        density["units"] = f"{density['units']} s"
        values = values / (2 * PI * _HZ[:, None])
    if dice.random() < 0.3:
        values = values.copy()
        values[3, 4] = 1e3 * values.max()
        told["valid_max"] = float(np.sort(values.ravel())[-2] * 1.01)
    wrapped = dice.random() < 0.3
    data = xr.Dataset(
        {efth: ((freq, direction), values, density | told)},
        {freq: (freq, _HZ / hertz_size, hertz), direction: (direction, ((_FROM + turn) % 360.0) / degrees, angle)},
    )
    if key:
        data[direction].attrs[key] = words
        case.words.append(words)
    unit = dice.choice(["", "m", "cm"])
    if unit:
        data["hs"] = (
            (),
            HEIGHT / LENGTHS[unit],
            {"units": unit, "standard_name": "sea_surface_wave_significant_height"},
        )
    for name in (efth, freq, direction) if wrapped else ():
        data[name].attrs = {
            each: [value] if isinstance(value, str) else value for each, value in data[name].attrs.items()
        }
    path = case.folder / "sea.nc"
    data.to_netcdf(path, engine="h5netcdf")
    return lambda: _as_read(path)


def spectrum_swan(case: Case) -> Judge:
    dice = case.dice
    area, one = dice.choice([("m2", 1.0), ("J/m2", 1 / (1025 * 9.81))])
    angle, two = dice.choice([("degr", 1.0), ("rad", PI / 180), ("deg", 1.0)])
    quantity, unit = ("VaDens" if area == "m2" else "EnDens"), f"{area}/Hz/{angle}"
    values = _table() / one / two
    if dice.random() < 0.3:
        quantity, unit = "AcDens", f"{area} s/Hz/{angle}"
        values = values / (2 * PI * _HZ[:, None])
    if dice.random() < 0.15:
        unit, case.known = dice.choice(["m2/Hz", "kg", "m2", "W/m2/Hz/degr"]), False
    case.words = [unit]
    word = dice.choice(["NDIR", "CDIR"])
    angles = _FROM if word == "NDIR" else 270.0 - _FROM
    lines = ["SWAN   1      Swan standard spectral file", "LOCATIONS", "1", "0.0 0.0", "AFREQ", str(_HZ.size)]
    lines += [*(f"{each:.4f}" for each in _HZ), word, str(angles.size), *(f"{each:.1f}" for each in angles)]
    factor = values.max() / 1e8
    lines += ["QUANT", "1", quantity, f"{unit}   unit", "-99.  exception value", "FACTOR", f"{factor:.9e}"]
    lines += [" ".join(str(each) for each in row) for row in np.rint(values / factor).astype(int)]
    path = case.folder / "sea.spc"
    path.write_text("\n".join(lines) + "\n")
    return lambda: _as_read(path)


def spectrum_buoy(case: Case) -> Judge:
    """NDBC's NetCDF: the mean direction of all frequencies is FROM, and they spread alike."""
    energies = {f"{area}/Hz": size for area, size in AREAS.items() if "J" not in area} | {
        "m2 s": 1.0,
        "m2/(rad/s)": 2 * PI,
    }
    hertz, hertz_size = case.unit(HERTZ)
    density, size = case.unit(energies)
    energy = 10.0 * _table().sum(axis=1)
    names = {
        "spectral_wave_density": energy / size,
        "wave_spectrum_r1": 0.8 + 0 * energy,
        "wave_spectrum_r2": 0.5 + 0 * energy,
    }
    data = {name: (("time", "frequency"), values[None]) for name, values in names.items()}
    file = xr.Dataset(
        data, {"frequency": ("frequency", _HZ / hertz_size, hertz), "time": [np.datetime64("2024-05-01", "ns")]}
    )
    file["spectral_wave_density"].attrs = density
    for name in ("mean_wave_dir", "principal_wave_dir"):
        angle, degrees = case.unit(ANGLES)
        file[name] = (("time", "frequency"), np.full((1, _HZ.size), FROM) / degrees, angle)
    path = case.folder / "buoy.nc"
    file.to_netcdf(path, engine="h5netcdf")
    return lambda: _as_read(path)


def recording(case: Case) -> Judge:
    pulses, gates, slow = 150, 12, np.linspace(-0.1, 0.3, 9)
    generator = np.random.default_rng(5)
    look = generator.standard_normal((2, pulses, gates)) + 1j * generator.standard_normal((2, pulses, gates))
    moments = np.arange(pulses) / 1000.0
    plain: dict[str, NDArray] = {
        "lower": look[0], "upper": look[1], "time": moments, "azimuth": 360.0 * moments, "attitude_time": slow,
        "ranges": 30.0 + 1.5 * np.arange(gates), "attitude": np.outer(np.sin(9 * slow), [3.0, 2.0, 1.0]),
        "position_time": slow, "position": np.outer(np.cos(9 * slow), [0.2, 0.1, 0.3]),
    }  # fmt: skip
    tables = {"time": TIMES, "attitude_time": TIMES, "position_time": TIMES, "ranges": LENGTHS, "position": LENGTHS,
              "azimuth": ANGLES, "attitude": ANGLES}  # fmt: skip
    head = {key: value for key, value in HEADER.items() if key not in ("first_gate_m", "gate_m")}

    def write(name: str, told: dict[str, tuple[dict[str, str], float]]) -> Path:
        path = case.folder / name
        with h5py.File(path, "w") as file:
            for each, values in plain.items():
                attributes, size = told.get(each, ({}, 1.0))
                values = values / size if size != 1.0 else values
                packing: dict[str, Any] = {}
                if each in tables and name == "night.h5" and case.dice.random() < 0.3:
                    packing = {"scale_factor": float(np.ptp(values)) / 2e9, "add_offset": float(values.min())}
                    values = np.rint((values - packing["add_offset"]) / packing["scale_factor"]).astype(np.int32)
                file.create_dataset(each, data=values).attrs.update(attributes | packing)
        return path

    chosen = case.dice.sample(list(tables), 3)
    told = {each: case.unit(tables[each]) for each in chosen}
    path, right = write("night.h5", told), write("plain.h5", {})

    def judge() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        found, wanted = (
            np.concatenate([np.ravel(opened[name].values).view(np.float64) if opened[name].dtype.kind == "c" else
                            np.ravel(opened[name].values).astype(np.float64)
                            for name in ("time", "azimuth", "range", "attitude", "position")])
            for opened in (open_recording(path, head), open_recording(right, head))
        )  # fmt: skip
        return found, wanted

    return judge


def sea_record(case: Case) -> Judge:
    axis, moments = np.arange(-32.0, 32.0), 0.25 * np.arange(40)
    height = np.cos(0.3 * axis - 1.7 * moments[:, None])[:, None, :] * np.ones((1, 64, 1))
    told = {"elevation": case.unit(LENGTHS), "x": case.unit(LENGTHS), "time": case.unit(TIMES)}
    told["y"] = told["x"]
    values = {"elevation": height, "x": axis, "y": axis, "time": moments}
    dims = {"elevation": ("time", "y", "x"), "x": "x", "y": "y", "time": "time"}
    data = xr.Dataset({n: (dims[n], values[n] / told[n][1], told[n][0]) for n in values})
    path = case.folder / "record.nc"
    data.set_coords(["x", "y", "time"]).to_netcdf(path, engine="h5netcdf")

    def judge() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        read = recorded_sea(str(path))
        facts = [read.step_s, *np.broadcast_to(read.spacing_m, 2), read.west_m, read.south_m]
        found = np.concatenate((np.ravel(read.elevation(20)), facts))
        return found, np.concatenate((height[20].ravel(), [0.25, 1.0, 1.0, -32.0, -32.0]))

    return judge


def pattern(case: Case) -> Judge:
    angles = np.arange(-90.0, 90.1, 3.0)
    gain, more = case.dice.choice([("30 dBi", 0.0), ("27.85 dBd", 0.0), ("27.85", 0.0), ("30,0 dBi", 0.0)])
    frequency = case.dice.choice(["10 GHz", "10000 MHz", "10000", "10000000 kHz", "1e4 MHz"])
    case.words = [gain, frequency]
    if case.dice.random() < 0.15:
        gain, case.known = case.dice.choice(["30 dBm", "30 kg", "1000 W"]), False
        case.words = [gain]
    text = f"NAME fuzz\nFREQUENCY {frequency}\nGAIN {gain}\n"
    for key, width in (("HORIZONTAL", 12.0), ("VERTICAL", 24.0)):
        text += f"{key} {angles.size}\n" + "".join(f"{a:g} {min(60.0, 12.0 * (a / width) ** 2):g}\n" for a in angles)
    path = case.folder / "antenna.msi"
    path.write_text(text)

    def judge() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        read = read_pattern(path)
        hertz = 1e10 if read.frequency_hz is None else read.frequency_hz
        return np.array([read.gain_dbi or np.nan, hertz]), np.array([30.0 + more, 1e10])

    return judge


def vessel(case: Case) -> Judge:
    """A boat of one degree of freedom that matters: what its response is at two frequencies and directions."""
    omega, towards = np.array([0.3, 0.7, 1.1, 1.6, 2.3]), np.arange(0.0, 360.0, 30.0)
    dofs, pair = ["Heave", "Roll", "Pitch"], ("influenced_dof", "radiating_dof")
    stiffness = np.diag([4e4, 9e3, 5e4])
    force = 4e4 * (1.0 + 0.1 * np.cos(np.radians(towards))) * np.exp(-((omega[:, None] - 0.3) ** 2))
    force = force[..., None] * np.array([1.0, 0.01, 0.02])
    split = np.stack([force, 0.1 * force])
    told = {"omega": case.unit(RATES), "wave_direction": case.unit({"rad": 1.0, "radian": 1.0, "degree": PI / 180})}
    dims = ("complex", "omega", "wave_direction", "influenced_dof")
    units = {"omega": omega, "wave_direction": np.radians(towards)}
    diagonals = {"added_mass": np.diag([1500.0, 300.0, 4000.0]), "radiation_damping": np.diag([2500.0, 400.0, 5000.0])}

    def write(name: str, told: dict[str, tuple[dict[str, str], float]]) -> Path:
        data = xr.Dataset(
            {each: (("omega", *pair), np.broadcast_to(matrix, (5, 3, 3))) for each, matrix in diagonals.items()}
            | {"diffraction_force": (dims, 0.25 * split), "Froude_Krylov_force": (dims, 0.75 * split)}
            | {"inertia_matrix": (pair, np.diag([900.0, 800.0, 3000.0])), "hydrostatic_stiffness": (pair, stiffness)},
            {"influenced_dof": dofs, "radiating_dof": dofs, "complex": ["re", "im"], "water_depth": np.inf, "g": 9.81}
            | {
                each: (each, values / told.get(each, ({}, 1.0))[1], told.get(each, ({}, 1.0))[0])
                for each, values in units.items()
            },
        )
        data.to_netcdf(case.folder / name, engine="h5netcdf")
        return case.folder / name

    path, right = write("boat.nc", told), write("plain.nc", {})

    def judge() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        found, wanted = (_numbers(read_capytaine(each)) for each in (path, right))
        return found, wanted

    return judge


def _numbers(vessel: Any) -> NDArray[np.float64]:
    held = [getattr(vessel, each.name) for each in fields(vessel)]
    arrays = [np.ravel(each) for each in held if isinstance(each, np.ndarray) and each.dtype.kind in "fc"]
    return np.concatenate([np.concatenate((np.real(each), np.imag(each))) for each in arrays])


READERS: dict[str, Callable[[Case], Judge]] = {
    "spectrum, NetCDF": spectrum_netcdf,
    "spectrum, SWAN": spectrum_swan,
    "spectrum, buoy": spectrum_buoy,
    "recording": recording,
    "recorded sea": sea_record,
    "pattern": pattern,
    "vessel": vessel,
}


def judged(reader: str, number: int, seed: int) -> tuple[str, str]:
    """What came of a case: read, or refused; and the law that it broke, if any."""
    with tempfile.TemporaryDirectory(prefix="declared-") as folder:
        case = Case(random.Random(f"{seed}/{reader}/{number}"), Path(folder))
        judge = READERS[reader](case)
        said = f"declared {case.words}"
        try:
            found, right = judge()
        except InputError as refusal:
            told = [*case.words, "rad/s", "no unit"] if reader.startswith("spectrum") else case.words
            if len(refusal.problems) != 1 or not any(word[:30] in str(refusal) for word in told):
                return "refused", f"{said}, refused without a word of it: {refusal}"
            return ("refused, though known" if case.known else "refused"), ""
    if not case.known:
        return "read", f"{said}, which is no unit of its kind, and was read"
    if found.shape != right.shape or not np.allclose(found, right, rtol=1e-4, atol=1e-5 * np.abs(right).max()):
        return "read", f"{said}, read as {found[:8]}, not {right[:8]}"
    return "read", ""


def run(cases: int, seed: int, say: Callable[[str], None]) -> list[str]:
    """The failures; a table of all readers and each failure is said."""
    begun, counts, failures = time.monotonic(), Counter[tuple[str, str]](), list[str]()
    for number in range(cases):
        reader = list(READERS)[number % len(READERS)]
        what, wrong = judged(reader, number // len(READERS), seed)
        counts[reader, what] += 1
        if wrong:
            failures.append(f"FAILED --seed {seed} --case '{reader}/{number // len(READERS)}': {wrong}")
            say(failures[-1])
    columns = ("read", "refused", "refused, though known")
    say(f"{'reader':>20}" + "".join(f"{each:>24}" for each in columns))
    for reader in READERS:
        say(f"{reader:>20}" + "".join(f"{counts[reader, each]:24d}" for each in columns))
    say(f"{cases} cases in {time.monotonic() - begun:.0f} s, {len(failures)} failed")
    return failures


def main() -> None:
    arguments = options(__doc__, cases=3_000, seed=1, case=str)
    if arguments.case:
        reader, _, number = arguments.case.rpartition("/")
        what, wrong = judged(reader, int(number), arguments.seed)
        print(what, wrong)
        sys.exit(bool(wrong))
    sys.exit(bool(run(arguments.cases, arguments.seed, print)))


if __name__ == "__main__":
    main()
