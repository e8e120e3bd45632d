"""Budgets of cycle time: what they are, what a program needs, and what became of them."""
