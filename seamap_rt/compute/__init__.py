"""How the numbers are worked out: compiled loops, vector lanes, threads, memory, and the backend that traces rays."""
