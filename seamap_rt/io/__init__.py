"""Scene files in and out."""
