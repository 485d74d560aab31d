"""A phase is a difference of paths: where the array stood, and which place on the sea has that difference."""
