"""The sum over facets, the innermost loop of the echoes: one typed batch in, sums at slow-time nodes out.

`sum_columns(batch)` is the interface: a kernel for another device takes the same `ColumnBatch` and returns the same
array. The processor's kernel is `processor`; random numbers by counting are in `gaussian`.
"""

from .batch import Beam, ColumnBatch, Columns, Geometry, ListedFacets, RangeTable, Speckle
from .processor import sum_columns

__all__ = [
    "Beam",
    "ColumnBatch",
    "Columns",
    "Geometry",
    "ListedFacets",
    "RangeTable",
    "Speckle",
    "sum_columns",
]
