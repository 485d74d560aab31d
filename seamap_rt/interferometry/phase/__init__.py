"""What a covariance's phase is worth: its spread, and which of its cycles is the right one."""
