"""The sea itself on file and in pictures (`writing`), and what the radar on its mast can see of it (`link`)."""
