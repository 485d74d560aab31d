"""Voltages → means of their products over each cell's dwell: what all later steps work on."""
