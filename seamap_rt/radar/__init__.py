"""The radar as built: waveform, antennas, scan timing, receiver."""
