"""Learns from the real robot: recordings, timing signatures, diagnosis, experiments."""
