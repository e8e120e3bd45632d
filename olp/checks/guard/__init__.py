"""Budgets of cycle time: their files, the times that programs need, and the verdicts."""
