"""A phase is a difference of paths: where the array stood, and which point on the sea has that difference."""
