"""The claims of the design study of 2004, and what this program finds."""
