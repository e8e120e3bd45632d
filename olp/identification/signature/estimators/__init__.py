"""One file per estimator: what is here is what `olp calibrate --method` knows."""
