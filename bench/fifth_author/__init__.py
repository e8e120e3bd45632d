"""Sealed recordings of a fifth author: a look-ahead controller over sampled inverse kinematics."""
