"""A covariance's phase: its spread, and which of its cycles is the right one."""
