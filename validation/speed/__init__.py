"""Seconds: stages, scaling, speed against error, peers."""
