"""The water: spectra, statistics, speed."""
