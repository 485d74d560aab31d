"""How the sea echoes: levels, Doppler, texture."""
