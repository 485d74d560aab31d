"""How well the sea is forecast."""
