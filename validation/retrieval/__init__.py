"""The maps: accuracy, error bars, floors, cycles, seconds."""
