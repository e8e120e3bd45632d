"""Runs a program: the plan of what happens, step by step."""
