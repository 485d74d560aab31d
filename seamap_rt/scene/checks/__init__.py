"""Checks across sections, by subject. Each takes the sections that it compares and raises ValueError, a line a problem:
key, value, limit, reason and remedy. A limit that a line names passes when it is typed in."""
