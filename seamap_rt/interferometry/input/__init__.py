"""What comes in: echoes, recordings and the radar's own description of itself, checked."""
