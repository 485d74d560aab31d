"""Metrics and figures → one page that says what was measured, how well, and what was left out."""
