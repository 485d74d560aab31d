"""What the converter costs: noise and phase error against its bits, the image of a real carrier, seconds, bytes.

    python -m validation.radar.digital [--pulses 2000] [--set receiver.if_hz=150e6]…

All against the linear chain, which has the same low-pass but neither carrier nor converter. The scene is thermal noise
and point reflectors 20 dB below full scale, each on a gate, whose phases differ by 0.5 rad between the receivers. `SNR`
is theirs over what the converter adds; `predicted` is from q²/12. `phase` is the rms error of their interferometric
phase, `less image` the same with the image put into the linear chain too: the rest is due to the converter.
"""

from __future__ import annotations

import argparse
import time
import tomllib

import numpy as np
from numpy.typing import NDArray

from seamap_rt.conventions import SPEED_OF_LIGHT, db
from seamap_rt.radar.digital import DigitalReceiver
from seamap_rt.radar.receiver import data_rate, thermal_noise
from seamap_rt.radar.waveform import RangeResponse
from seamap_rt.settings import RadarSettings

from ..claims.data_rate import CLAIM, claim_data_rate

BITS = (1, 2, 4, 6, 8, 10, 12, 14, 16, 24)
PHASE = 0.5  # rad


def radar_of(changes: list[str], **receiver: object) -> RadarSettings:
    """The radar as built, with changes of its keys."""
    tree: dict = {"receiver": {"chain": "digital"}}
    for change in changes:
        key, value = change.split("=", 1)
        section, _, name = key.rpartition(".")
        (tree.setdefault(section, {}) if section else tree)[name] = tomllib.loads(f"x = {value}")["x"]
    tree["receiver"].update(receiver)
    return RadarSettings.model_validate(tree)


def noise_and_reflectors(radar: RadarSettings, receiver: DigitalReceiver, pulses: int, gates: NDArray) -> NDArray:
    """Envelope (pulse, receiver, sample): thermal noise, and reflectors of random phase on the given gates."""
    random = np.random.default_rng(1)
    step = SPEED_OF_LIGHT / (2.0 * radar.receiver.adc_rate_hz)
    envelope = thermal_noise(radar, pulses, receiver.sample_range.size, random, spacing_m=step)
    level = np.sqrt(1e-2 * 1e-3 * 10.0 ** (0.1 * radar.receiver.full_scale_dbm))
    shape = RangeResponse.of(radar)(receiver.sample_range - receiver.range_m[gates, None])
    lower = level * np.exp(2j * np.pi * random.random((pulses, gates.size)))
    for channel, volts in enumerate((lower, lower * np.exp(-1j * PHASE))):
        envelope[:, channel] += (volts @ shape).astype(np.complex64)
    return envelope


def with_image(radar: RadarSettings, receiver: DigitalReceiver, envelope: NDArray) -> NDArray:
    """V + V* exp(−2jθ), which a real carrier of phase θ leaves of an envelope."""
    instants = np.arange(receiver.sample_range.size) - receiver.taps.size // 2
    cycles = np.remainder(2.0 * instants * (radar.receiver.if_hz / radar.receiver.adc_rate_hz), 1.0)
    return envelope + envelope.conj() * np.exp(-2j * np.pi * cycles)


def phase_error(quantised: NDArray, exact: NDArray) -> float:
    """rms [rad] over pulses and gates of the interferometric phase, of voltages (pulse, receiver, gate)."""
    products = [voltage[:, 0] * voltage[:, 1].conj() for voltage in (quantised, exact)]
    return float(np.sqrt(np.mean(np.angle(products[0] * products[1].conj()) ** 2)))


def against_bits(changes: list[str], pulses: int) -> None:
    print(f"{'bits':>4}{'SNR':>9}{'predicted':>11}{'phase':>11}{'less image':>12}{'predicted':>11}{'mean phase':>12}")
    print(f"{'':>4}{'dB':>9}{'dB':>11}{'rad':>11}{'rad':>12}{'rad':>11}{'rad':>12}")
    for bits in BITS:
        radar = radar_of(changes, adc_bits=bits)
        receiver = DigitalReceiver(radar)
        gates = np.arange(10, receiver.range_m.size, 40)
        envelope = noise_and_reflectors(radar, receiver, pulses, gates)
        digitised = receiver(envelope)
        quantised, linear = digitised.voltage[..., gates], receiver.ideal(envelope)[..., gates]
        exact = receiver.ideal(with_image(radar, receiver, envelope))[..., gates]
        power = np.mean(np.abs(exact) ** 2)
        snr = power / np.mean(np.abs(quantised - exact) ** 2)
        predicted = power / np.mean(receiver.quantisation_noise_power(float(digitised.full_scale[0]))[gates])
        mean = np.angle(np.sum(quantised[:, 0] * quantised[:, 1].conj()))
        print(
            f"{bits:4d}{float(db(snr)):9.2f}{float(db(predicted)):11.2f}{phase_error(quantised, linear):11.2e}"
            f"{phase_error(quantised, exact):12.2e}{1.0 / np.sqrt(predicted):11.2e}{mean:12.4f}"
        )


def noise_gains(receiver: DigitalReceiver) -> tuple[float, float]:
    """What the low-pass leaves of the thermal noise's mean power (kTBF in the envelope): of the band itself, and of
    its image, from beyond the zone's edge. Their sum is the gates' thermal noise over kTBF."""
    radar, number = receiver.radar, np.arange(receiver.taps.size)
    apart = number[:, None] - number
    pulse = RangeResponse(radar.pulse_width_s, radar.bandwidth_hz)  # before a chirp is compressed
    correlation = pulse.noise_correlation(0.5 * SPEED_OF_LIGHT / radar.receiver.adc_rate_hz * apart)
    weight = np.outer(receiver.taps, receiver.taps) * correlation
    turns = 2.0 * receiver.zone.alias_hz / radar.receiver.adc_rate_hz * apart
    return float(weight.sum()), float(np.sum(weight * np.cos(2.0 * np.pi * turns)))


def zone_and_image(changes: list[str]) -> None:
    radar = radar_of(changes)
    receiver = DigitalReceiver(radar)
    zone, (band, image) = receiver.zone, noise_gains(receiver)
    print(
        f"IF {1e-6 * radar.receiver.if_hz:g} MHz at {1e-6 * radar.receiver.adc_rate_hz:g} MS/s: zone {zone.number}, "
        f"{'mirrored' if zone.mirrored else 'upright'}, alias {1e-6 * zone.alias_hz:g} MHz, "
        f"{1e-6 * zone.room_hz:g} MHz to the edge; every {receiver.decimation}. sample, {receiver.taps.size} taps"
    )
    response = RangeResponse.of(radar)
    offsets = np.linspace(-0.5, 0.5, 21) * receiver.decimation * 0.5 * SPEED_OF_LIGHT / radar.receiver.adc_rate_hz
    middle = receiver.range_m.size // 2
    point = response(receiver.sample_range - receiver.range_m[middle] - offsets[:, None]).astype(complex)
    echo = receiver.ideal(point)[:, middle]
    ghost = receiver.ideal(with_image(radar, receiver, point))[:, middle] - echo
    share = np.mean(np.abs(ghost) ** 2) / np.mean(np.abs(echo) ** 2)
    print(
        f"thermal noise of a gate {float(db(band)):.2f} dB of kTBF, its image {float(db(image / band)):.1f} dB of it; "
        f"a reflector's peak {float(db(np.abs(echo[10] / response(0.0)) ** 2)):.2f} dB of its envelope's, its image "
        f"{float(db(share)):.1f} dB of it"
    )


def seconds(changes: list[str]) -> None:
    radar = radar_of(changes)
    receiver = DigitalReceiver(radar)
    envelope = np.tile(noise_and_reflectors(radar, receiver, 1000, np.array([10])), (10, 1, 1))
    for gain in ("fixed", "agc"):
        receiver = DigitalReceiver(radar_of(changes, gain=gain))
        spent = []
        for _ in range(4):
            start = time.perf_counter()
            receiver(envelope)
            spent.append(time.perf_counter() - start)
        print(f"{envelope.shape[0]} pulses, 2 receivers, {envelope.shape[2]} samples, gain {gain}: {min(spent):.2f} s")


def bytes_per_second(changes: list[str]) -> None:
    rates = data_rate(radar_of(changes))._asdict()
    print("this radar, MB/s: " + ", ".join(f"{name} {1e-6 * rate:.2f}" for name, rate in rates.items()))
    print(f"readings of the study's {1e-6 * CLAIM:g} MB/s at 10 kHz over 400 m:")
    for reading in claim_data_rate():
        bits = f"{reading.bits // 2}+{reading.bits // 2}" if "complex" in reading.sampling else f"{reading.bits}"
        rate = f"{1e-6 * reading.bytes_per_second:8.2f} MB/s{'   fits' if reading.fits else ''}"
        print(f"  {reading.receivers} × {reading.sampling:16}{bits:>6} bit{rate}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pulses", type=int, default=2000)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="any key of the radar")
    arguments = parser.parse_args()
    zone_and_image(arguments.set)
    against_bits(arguments.set, arguments.pulses)
    seconds(arguments.set)
    bytes_per_second(arguments.set)


if __name__ == "__main__":
    main()
