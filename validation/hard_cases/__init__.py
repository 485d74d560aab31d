"""Numerical stability: cases whose right answer is known."""
