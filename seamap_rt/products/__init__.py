"""The sea itself on file and in pictures, moment by moment, and what of it the radar on its mast can see."""

from .writing import DEFAULT_TIMES, PRODUCTS, SeaProducts, write_sea

__all__ = ["DEFAULT_TIMES", "PRODUCTS", "SeaProducts", "write_sea"]
