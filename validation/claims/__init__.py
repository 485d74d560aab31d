"""What the design study of 2004 claimed, and what comes out."""
