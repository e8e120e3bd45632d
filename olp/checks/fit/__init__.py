"""Finds the cheapest edits that bring a program down to a given time."""
