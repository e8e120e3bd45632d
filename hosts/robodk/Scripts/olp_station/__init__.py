"""A robot program in RoboDK's station: `steps.py` asks olp, `build.py` tells RoboDK."""
