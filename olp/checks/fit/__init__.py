"""The cheapest edits that bring a program down to a time."""
