"""Cases for `olp diagnose` from an author who had read its contract alone, and not its code."""
