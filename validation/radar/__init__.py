"""The radar and its boat: antenna, modes, waveforms, converter, motion."""
