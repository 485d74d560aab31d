"""How the numbers are computed: compiled loops, threads, memory, and the backend that traces rays."""
