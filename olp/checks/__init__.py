"""What must hold of programs: lint, budgets, differences, changes of positions."""
