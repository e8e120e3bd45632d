"""The smallest experiment: which moves to measure, proved to be possible, as a job for the robot. docs/probe.md."""

from olp.identification.probe.experiment import Experiment, Wanted, design_experiment, further_experiment
from olp.identification.probe.job import write_experiment

__all__ = ["Experiment", "Wanted", "design_experiment", "further_experiment", "write_experiment"]
