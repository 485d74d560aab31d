"""What the metrics say of maps whose errors are known."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from scipy.special import ndtri

from seamap_rt.dataset import SCHEMA, build
from seamap_rt.metrics import compare

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
    found = compare(maps, truth)["overall"]
    assert found["height_bias_m"] == pytest.approx(0.2, abs=1e-6)  # of float32
    assert found["height_robust_m"] == pytest.approx(0.05, rel=3e-3)
    assert found["height_rmse_m"] == pytest.approx(np.hypot(0.2, 0.05), rel=1e-3)
    assert found["hs_true_m"] == pytest.approx(1.6, rel=2e-3)  # about the mean: the level is no wave
