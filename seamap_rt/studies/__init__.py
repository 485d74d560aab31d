"""Loops over simulate: shadowing range, antenna-height trade, speed against error. None yet."""
