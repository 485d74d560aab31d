"""A small scene whose sea is written to file, without the pictures."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from seamap_rt.products.writing import SeaProducts, write_sea
from seamap_rt.report import sea_figures, spectrum_figures, style
from seamap_rt.scene import Scene, load_scene

SIDE, SPACING, STEP = 60.0, 0.25, 0.05  # m, m, s
PNG = style.png
DRAWINGS = (  # module, function's name, function
    (spectrum_figures, "directional_spectrum", spectrum_figures.directional_spectrum),
    (sea_figures, "sea_surface", sea_figures.sea_surface),
    (sea_figures, "animation", sea_figures.animation),
)


def scene(**keys: Any) -> Scene:
    """A small wind sea on a current; the radar looks at a sector of it that spans north."""
    small: dict[str, Any] = {
        "sea__extent_m": 128.0,
        "sea__resolution_m": 1.6,
        "sea__current_m_s": 0.8,
        "sea__current_toward_deg": 20.0,
        "sea__waves__0__significant_wave_height_m": 0.9,
        "sea__waves__0__peak_period_s": 4.0,
        "sea__waves__0__wave_from_deg": 300.0,
        "radar__range_m": [12.0, 30.0],
        "radar__sector_deg": [250.0, 400.0],
        "radar__height_m": 3.0,
        "tracing__tracer": "horizon",
    }
    return load_scene("tiny", overrides={key.replace("__", "."): value for key, value in (small | keys).items()})


@pytest.fixture(scope="module", autouse=True)
def without_pictures() -> Iterator[None]:
    """Pictures are tested on their own: most of the time would go into them."""
    with pytest.MonkeyPatch.context() as patch:
        for module, name, _ in DRAWINGS:
            patch.setattr(module, name, lambda *_: b"")
        patch.setattr(style, "png", lambda figure: figure)
        patch.setattr("seamap_rt.tracing.picture.render_from_mast", lambda *_, **__: np.zeros((1, 1, 3)))
        yield


def written(folder: Path, made: Scene, **options: Any) -> tuple[xr.Dataset, SeaProducts]:
    """The fields on file, in memory, time in seconds."""
    result = write_sea(made, folder, **options)
    with xr.open_dataset(folder / "sea.nc", decode_times=False) as fields:
        return fields.load(), result
