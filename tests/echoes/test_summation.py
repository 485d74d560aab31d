"""The sum over facets: a batch in, its sums out, against the law in float64."""

from __future__ import annotations

from typing import Any, get_args, get_type_hints

import numpy as np
import pytest
from exact_echoes import ROCKING, SEED, radar_of, sea_seen
from numpy.typing import NDArray

from seamap_rt.echoes import turn, turn_voltages
from seamap_rt.echoes.speckle import Motion
from seamap_rt.echoes.summation import (
    Beam,
    ColumnBatch,
    Columns,
    Geometry,
    ListedFacets,
    RangeTable,
    Speckle,
    sum_columns,
)
from seamap_rt.echoes.summation.gaussian import gaussians, key_of
from seamap_rt.radar.installation import Installation
from seamap_rt.random_streams import Stream, key


def batch_of(window: int = 13, kinds: int = 2, alike: bool = False, seed: int = 1) -> ColumnBatch:
    """Three columns, the second of which has no facets, of three antennas; alike: all paths share tables."""
    rng = np.random.default_rng(seed)
    paths, gates, antennas = np.array([[0, 0], [0, 1], [1, 2]]), 9, 3
    count, tables = 6, 1 if alike else len(paths)
    velocity = rng.normal(0.0, 3.0, (antennas, count))
    offset = np.abs(np.arange(400) + 0.5) / 100.0
    table = np.exp(-(offset**2)) * (1.0 + np.arange(tables))[:, None]
    table[:, -1] = 0.0
    cosine = np.linspace(-0.1, 0.1, 2**14)
    legs = 1 if alike else 2
    beam = np.exp(-((cosine / (0.03 + 0.01 * np.arange(tables * legs)[:, None])) ** 2)).reshape(tables, legs, -1)
    drop = np.asarray(5.0 / (30.0 + 1.5 * np.arange(gates)), dtype=np.float64)
    modes = rng.normal(size=(3, 5, window)) + 1j * rng.normal(size=(3, 5, window))
    return ColumnBatch(
        window=window,
        nodes=window + 6,
        columns=Columns(
            number=np.array([40, 41, 42]),
            first_facet=np.array([0, 4, 4, 6]),
            first_node=np.array([0, 3, 6]),
            begin_s=np.array([-3e-3, -2.9e-3, -3.1e-3]),
        ),
        facets=ListedFacets(
            number=np.array([3, 7, 11, 2, 5, 6]),
            range_m=np.array([28.003, 31.303, 33.003, 36.103, 40.203, 43.003]),  # within the table's entries
            difference_m=np.concatenate((np.zeros((1, count)), rng.normal(0.0, 0.1, (2, count)))),
            radial_velocity=np.repeat(velocity[:1], antennas, axis=0) if alike else velocity,
            amplitude=(rng.normal(size=(3, count)) + 1j * rng.normal(size=(3, count))).astype(np.complex64),
        ),
        speckle=Speckle(
            streams=np.array([key(3, Stream.SPECKLE, kind) for kind in range(kinds)]),
            modes=modes.astype(np.complex64),
            first_kind_modes=5 if kinds == 1 else 3,
            strength=rng.uniform(size=(count, kinds)).astype(np.float32),
        ),
        geometry=Geometry(paths, 209.6, 5e-4),
        response=RangeTable(table.astype(np.float32), 100.0, 30.0, 1.5),
        beam=Beam(
            table=beam.astype(np.float32),
            entries_per_cosine=(cosine.size - 1) / 0.2,
            aside_m=rng.normal(0.0, 0.2, (tables, legs)),
            level=np.sqrt(1.0 - drop**2),
            drop=drop,
            inverse_range=np.asarray(drop / 5.0, dtype=np.float64),
            along=np.linspace(-0.05, 0.05, window) + rng.normal(0.0, 1e-3, (3, 1)),
            up=rng.normal(0.0, 0.02, (3, window)),
            past_m=rng.normal(0.0, 0.1, (3, window)),
        ),
    )


def by_the_law(batch: ColumnBatch) -> NDArray[np.complex128]:
    """(path, gate, node) in float64, with the tables' nearest entries."""
    beam, response, facets, speckle = batch.beam, batch.response, batch.facets, batch.speckle
    gates = response.first_gate_m + response.gate_spacing_m * np.arange(beam.level.size)
    out = np.zeros((len(batch.geometry.antennas), gates.size, batch.nodes), complex)
    modes = np.split(speckle.modes, [speckle.first_kind_modes], axis=1)[: speckle.streams.size]
    for column, number in enumerate(batch.columns.number):
        seconds = batch.columns.begin_s[column] + batch.geometry.node_spacing_s * np.arange(batch.window)
        window = slice(batch.columns.first_node[column], batch.columns.first_node[column] + batch.window)
        for n in range(batch.columns.first_facet[column], batch.columns.first_facet[column + 1]):
            series = np.zeros(batch.window, complex)
            for stream, kind, strength in zip(speckle.streams, modes, speckle.strength[n], strict=True):
                drawn = gaussians(np.uint64(key_of(stream, number)), int(facets.number[n]) + 1, kind.shape[1])
                series += strength * (drawn[:, -1].astype(complex) @ kind[column])
            for path, (i, j) in enumerate(batch.geometry.antennas):
                length = 2.0 * facets.range_m[n] + facets.difference_m[i, n] + facets.difference_m[j, n]
                velocity = facets.radial_velocity[i, n] + facets.radial_velocity[j, n]
                phase = batch.geometry.wavenumber * (length + velocity * seconds)
                row = path % len(response.table)
                entry = (np.abs(0.5 * length - gates) * response.entries_per_m).astype(int)
                height = response.table[row, np.minimum(entry, response.table.shape[1] - 1)]
                own = int(np.abs(0.5 * length - gates).argmin())
                pattern = np.ones(batch.window)
                row = path % len(beam.table)
                for table, aside in zip(beam.table[row], beam.aside_m[row], strict=True):
                    cosine = beam.level[own] * beam.along[column] - beam.drop[own] * beam.up[column]
                    cosine = cosine - beam.inverse_range[own] * (beam.past_m[column] + aside)
                    entry = np.floor(cosine * beam.entries_per_cosine + 0.5 * table.size).astype(int)
                    pattern = pattern * table[np.clip(entry, 0, table.size - 1)]
                voltage = facets.amplitude[path, n] * pattern * series * np.exp(-1j * phase)
                out[path, :, window] += height[:, None] * voltage
    return out


@pytest.mark.parametrize("window", [1, 8, 13, 40])  # less than are taken together, just half, more
@pytest.mark.parametrize("kinds", [1, 2])
@pytest.mark.parametrize("alike", [True, False], ids=["tables alike", "tables of each path"])
def test_sums_by_the_law(window: int, kinds: int, alike: bool) -> None:
    # Single precision, and phasors that err by 1e-5 rad; a beam's entry that rounds to its neighbour is 4e-4 of it.
    batch = batch_of(window, kinds, alike)
    sums, exact = sum_columns(batch), by_the_law(batch)
    assert sums.dtype == np.float32
    assert sums.shape == (2, *exact.shape)
    np.testing.assert_allclose(sums[0] + 1j * sums[1], exact, rtol=0, atol=1e-4 * np.abs(exact).max())


def test_a_batch_is_the_sum_of_its_columns() -> None:
    """A facet's numbers are those of its column's and its own keys, whatever else is in the batch."""
    batch = batch_of()
    whole, total = sum_columns(batch), 0.0
    for column in range(3):
        alone = batch.columns.first_facet.copy()
        alone[: column + 1], alone[column + 1 :] = alone[column], alone[column + 1]
        if column:  # those before stay empty
            alone[:column] = alone[column]
        total = total + sum_columns(batch._replace(columns=batch.columns._replace(first_facet=alone)))
    np.testing.assert_allclose(whole, total, rtol=0, atol=1e-6 * np.abs(whole).max())
    np.testing.assert_array_equal(whole, sum_columns(batch))


@pytest.mark.parametrize("moving", [False, True], ids=["still", "moving scatterers"])
def test_a_turns_batches_are_as_they_are_described(moving: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every array C-contiguous, of the type that is written beside it and of the length that its axes have."""
    facets, rcs, fired = sea_seen(radar_of(), ROCKING)
    columns = facets.height.shape[0]
    share = np.random.default_rng(1).uniform(size=rcs.shape).astype(np.float32)
    motion = Motion(0.24, np.full(columns, 0.5), share, np.zeros(columns), 0.3) if moving else None
    seen = list[ColumnBatch]()

    def recorded(batch: ColumnBatch) -> NDArray[np.float32]:
        seen.append(batch)
        return sum_columns(batch)

    monkeypatch.setattr(turn, "sum_columns", recorded)
    monkeypatch.setattr(turn, "BATCH_COLUMNS", 16)
    turn_voltages(facets, rcs, Installation(radar_of()), fired, SEED, 0.01, motion=motion)
    assert seen
    for batch in seen:
        for group in (batch.columns, batch.facets, batch.speckle, batch.geometry, batch.response, batch.beam):
            for name, hint in get_type_hints(type(group)).items():
                value: Any = getattr(group, name)
                if isinstance(hint, type):
                    assert isinstance(value, hint), name
                    continue
                assert value.flags["C_CONTIGUOUS"], name
                assert value.dtype == np.dtype(get_args(get_args(hint)[1])[0]), name
        count, each = batch.facets.number.size, batch.columns.number.size
        paths, antennas = len(batch.geometry.antennas), batch.facets.difference_m.shape[0]
        assert batch.columns.first_facet.shape == (each + 1,)
        assert batch.columns.first_facet[-1] == count
        assert batch.columns.first_node.min() == 0
        assert batch.columns.first_node.max() + batch.window == batch.nodes
        assert batch.facets.radial_velocity.shape == (antennas, count)
        assert batch.facets.amplitude.shape == (paths, count)
        assert batch.speckle.strength.shape == (count, batch.speckle.streams.size)
        assert batch.speckle.modes.shape[::2] in ((each, batch.window), (1, batch.window))
        assert batch.beam.along.shape == batch.beam.up.shape == batch.beam.past_m.shape == (each, batch.window)
