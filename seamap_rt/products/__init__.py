"""The sea itself on file and in pictures (`writing`), and what of it the radar on its mast can see (`link`)."""
