"""Where a simulation and a recording differ, which physics was left out, and whether that holds. docs/diagnose.md."""
