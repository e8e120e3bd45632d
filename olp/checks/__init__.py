"""Checks of programs: lint, budgets, differences, changes of positions."""
