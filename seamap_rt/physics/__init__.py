"""Formulas that several subpackages need, each in one place."""
