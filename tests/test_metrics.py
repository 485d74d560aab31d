"""What the metrics say of maps whose errors are known."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from scipy.special import ndtri

from seamap_rt.dataset import SCHEMA, build
from seamap_rt.errors import InputError
from seamap_rt.metrics import compare, error_figures

CELLS = (1, 40, 30)  # turn, azimuth, range
RANGES = 60.0 + 4.0 * np.arange(30)


def tree(product: str, **fields: np.ndarray) -> xr.DataTree:
    """A tree of one group; what is required and not given is 0."""
    coords = {"turn": [0], "azimuth": 9.0 * np.arange(CELLS[1]), "range": RANGES}
    sizes = dict(zip(coords, CELLS, strict=True))
    empty = {
        name: np.zeros([sizes[each] for each in variable.dims])
        for name, variable in SCHEMA[product].items()
        if variable.required and name not in coords
    }
    group = build(product, empty | fields, coords)
    return xr.DataTree.from_dict({product.split("/")[1]: group})


def test_a_common_error_is_bias_and_no_spread() -> None:
    """Heights of σ = 0.4 m on a level of 0.3 m, errors of a normal law of σ = 0.05 m about a bias of 0.2 m."""
    count = int(np.prod(CELLS))
    normal = ndtri((np.arange(count) + 0.5) / count)  # its deviation is 1 to 1e-3, its median absolute one 1/1.4826
    order = np.random.default_rng(1)
    sea, spread = (size * order.permutation(normal).reshape(CELLS) for size in (0.4, 0.05))
    level = sea + 0.3
    truth = tree("truth/polar", height=level, height_visible=level, visible_fraction=np.ones(CELLS))
    maps = tree("maps/polar", height=level + spread + 0.2)
    found = error_figures(maps, truth)["overall"]
    assert found["height_bias_m"] == pytest.approx(0.2, abs=1e-6)  # of float32
    assert found["height_robust_m"] == pytest.approx(0.05, rel=3e-3)
    assert found["height_rmse_m"] == pytest.approx(np.hypot(0.2, 0.05), rel=1e-3)
    assert found["hs_true_m"] == pytest.approx(1.6, rel=2e-3)  # about the mean: the level is no wave


def test_a_comparison_holds_what_metrics_json_holds() -> None:
    """Each figure by range and over all, with its unit; NaN where metrics.json has null."""
    level = np.random.default_rng(2).normal(size=CELLS)
    seen = np.where(RANGES < 100.0, 1.0, 0.0)[None, None, :] * np.ones(CELLS)
    truth = tree("truth/polar", height=level, height_visible=level, visible_fraction=seen)
    maps = tree("maps/polar", height=level + 0.1)
    compared, figures = compare(maps, truth), error_figures(maps, truth)
    overall = figures.pop("overall")
    np.testing.assert_array_equal(compared["range"].values, figures.pop("range_m"))
    assert compared.attrs["overall_range_m"] == list(overall.pop("range_m"))
    assert set(compared.data_vars) == {*figures, *(f"overall_{name}" for name in overall)}
    for name, values in (figures | {f"overall_{name}": value for name, value in overall.items()}).items():
        np.testing.assert_array_equal(compared[name].values, np.array(values, dtype=np.float64))
        assert compared[name].attrs["units"] == ("m" if name.endswith("_m") else "1")
    assert float(compared["overall_height_bias_m"]) == pytest.approx(0.1, abs=1e-6)
    assert np.isnan(compared["height_rmse_m"].values[-1])
    assert compared["cells"].dtype.kind == "i"


def test_other_cells_are_no_comparison() -> None:
    truth = tree("truth/polar")
    with pytest.raises(InputError, match="different cells"):
        compare(xr.DataTree.from_dict({"polar": tree("maps/polar")["polar"].to_dataset().isel(range=slice(3))}), truth)


def test_figures_are_of_bins_of_25_m_and_of_50_to_200_m_with_both_ends() -> None:
    """An error of its own in each gate: the bins' biases are the means over [0, 25), [25, 50) … m, and the headline's
    that over 50 to 200 m."""
    ranges = np.array([10.0, 24.9, 25.0, 49.9, 50.0, 120.0, 199.0, 200.0, 200.1, 240.0])
    bias = np.arange(10.0) ** 2
    shape = (1, CELLS[1], ranges.size)
    trees = []
    for product, given in (("maps/polar", bias), ("truth/polar", 0.0 * bias)):
        values = tree(product)[product.split("/")[1]].to_dataset().isel(range=slice(0, ranges.size))
        values = values.assign_coords(range=ranges)
        values["height"] = values["height"].dims, np.broadcast_to(given, shape)
        if product == "truth/polar":
            values["visible_fraction"] = values["visible_fraction"].dims, np.ones(shape)
        trees.append(xr.DataTree.from_dict({"polar": values}))
    found = error_figures(*trees)
    np.testing.assert_allclose(found["range_m"], [12.5, 37.5, 62.5, 112.5, 187.5, 212.5, 237.5])
    expected = [bias[:2].mean(), bias[2:4].mean(), *bias[4:7], bias[7:9].mean(), bias[9]]
    np.testing.assert_allclose(found["height_bias_m"], expected, rtol=1e-6)
    assert found["overall"]["height_bias_m"] == pytest.approx(bias[4:8].mean())
    assert found["overall"]["range_m"] == (50.0, 200.0)
    assert found["overall"]["cells"] == 4 * CELLS[1]
