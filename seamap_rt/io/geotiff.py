"""GeoTIFF of one turn's ground map: a band a field, row 0 in the north, no data NaN.

Keys by OGC 19-008r4 (GeoTIFF 1.1): a projected system of its own, azimuthal equidistant about the maps' origin.
"""

from __future__ import annotations

from collections.abc import Mapping
from io import BytesIO
from xml.sax.saxutils import escape

import numpy as np
from numpy.typing import NDArray

from .geography import Origin

_PIXEL_SCALE, _TIE_POINT, _GEO_KEYS, _GEO_DOUBLES, _GEO_TEXTS = 33550, 33922, 34735, 34736, 34737
_GDAL_METADATA, _GDAL_NO_DATA = 42112, 42113  # GDAL's own: names of the bands, and what stands for no data
_DOUBLE, _SHORT, _TEXT = 12, 3, 2  # types of TIFF 6.0
_PROJECTED, _PIXEL_IS_AREA, _USER_DEFINED, _WGS84, _EQUIDISTANT, _METRE, _DEGREE = 1, 1, 32767, 4326, 12, 9001, 9102


def geotiff(bands: Mapping[str, NDArray], x: NDArray, y: NDArray, origin: Origin, facts: Mapping[str, object]) -> bytes:
    """The file. bands: name → (y, x). x, y: metres east and north of the cells' middles, both ascending and evenly
    spaced. facts: what else the file is to say, name → value."""
    from tifffile import imwrite

    dx, dy = ((float(axis[-1] - axis[0]) / (axis.size - 1)) for axis in (x, y))
    image = np.stack([np.asarray(band, dtype=np.float32)[::-1] for band in bands.values()])
    names = [
        f'<Item name="DESCRIPTION" sample="{number}" role="description">{escape(name)}</Item>'
        for number, name in enumerate(bands)
    ]
    items = [f'<Item name="{escape(name)}">{escape(str(value))}</Item>' for name, value in facts.items()]
    tags = [
        (_PIXEL_SCALE, _DOUBLE, 3, (dx, dy, 0.0)),
        (_TIE_POINT, _DOUBLE, 6, (0.0, 0.0, 0.0, float(x[0]) - 0.5 * dx, float(y[-1]) + 0.5 * dy, 0.0)),
        *_keys(origin),
        (_GDAL_METADATA, _TEXT, 0, f"<GDALMetadata>{''.join([*items, *names])}</GDALMetadata>"),
        (_GDAL_NO_DATA, _TEXT, 0, "nan"),
    ]
    file = BytesIO()
    imwrite(
        file,
        image,
        photometric="minisblack",
        planarconfig="separate",
        compression="zlib",
        metadata=None,
        software="seamap_rt",
        extratags=[(code, kind, count, value, True) for code, kind, count, value in tags],
    )
    return file.getvalue()


def _keys(origin: Origin) -> list[tuple[int, int, int, object]]:
    doubles = (origin.longitude, origin.latitude, 0.0, 0.0)
    text = "azimuthal equidistant about the radar|"
    keys = [  # key, where its value is (0: here), how many, value or its place
        (1024, 0, 1, _PROJECTED),  # model
        (1025, 0, 1, _PIXEL_IS_AREA),
        (2048, 0, 1, _WGS84),  # geodetic system
        (2054, 0, 1, _DEGREE),
        (3072, 0, 1, _USER_DEFINED),  # projected system
        (3073, _GEO_TEXTS, len(text), 0),
        (3074, 0, 1, _USER_DEFINED),  # projection
        (3075, 0, 1, _EQUIDISTANT),
        (3076, 0, 1, _METRE),
        (3082, _GEO_DOUBLES, 1, 2),  # false easting
        (3083, _GEO_DOUBLES, 1, 3),  # false northing
        (3088, _GEO_DOUBLES, 1, 0),  # longitude of the centre
        (3089, _GEO_DOUBLES, 1, 1),  # latitude of the centre
    ]
    directory = (1, 1, 1, len(keys), *(number for key in keys for number in key))
    return [
        (_GEO_KEYS, _SHORT, len(directory), directory),
        (_GEO_DOUBLES, _DOUBLE, len(doubles), doubles),
        (_GEO_TEXTS, _TEXT, 0, text),
    ]
