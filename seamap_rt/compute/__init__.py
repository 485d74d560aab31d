"""How the numbers are computed: compiled loops, vector lanes, threads, memory, and the backend that traces rays."""
