"""The blind proof of `olp diagnose`: recordings with a hidden cause, a sealed answer, and a score. docs/concealed.md.

Nothing here imports the models that are judged: arms are rigid bodies in MuJoCo, controllers are played in time steps.
"""
