"""The sum over facets, the innermost loop of the echoes: one typed batch in, sums at slow-time nodes out.

`sum_columns(batch)` is the interface; its loops are compiled (`processor`). Random numbers by counting are in
`gaussian`.
"""

from __future__ import annotations

from .batch import Beam, ColumnBatch, Columns, Geometry, ListedFacets, RangeTable, Speckle
from .processor import BATCH_COLUMNS, sum_columns

__all__ = [
    "BATCH_COLUMNS",
    "Beam",
    "ColumnBatch",
    "Columns",
    "Geometry",
    "ListedFacets",
    "RangeTable",
    "Speckle",
    "sum_columns",
]
