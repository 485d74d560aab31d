"""Cells of the polar map → square maps on the ground, at one moment."""
