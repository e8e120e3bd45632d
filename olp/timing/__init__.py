"""How long each step of a plan takes: motion models, corners, path limits, physics terms."""
