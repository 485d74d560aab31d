"""Checks across sections, by subject. Each takes the sections that it compares and gives a line for each problem, or
raises ValueError with one: key, value, limit, reason, remedy. A limit that a line names passes when it is typed in."""
