"""How the sea scatters: mean level, Doppler, texture, seconds of the options."""
