"""The list of motion models, and the check that each runs on itself; the rest is `olp.contracts.check_model`."""

from __future__ import annotations

from pathlib import Path

import pytest

import olp.timing.motion
from olp.core.diagnostic import OlpError
from olp.timing.motion import MotionModel, Profile, load_model, model_names

MODELS = model_names()
every_model = pytest.mark.parametrize("model", [load_model(n) for n in MODELS], ids=MODELS)


def test_the_folder_is_the_list_of_models() -> None:
    folder = Path(olp.timing.motion.__file__).parent
    files = {f.stem for f in folder.glob("*.py") if not f.stem.startswith("_")} - {"model"}
    assert set(MODELS) == files >= {"constant", "linear"}


def test_an_unknown_model_is_answered_with_the_models_there_are() -> None:
    with pytest.raises(OlpError) as caught:
        load_model("quadratic")
    assert "constant, linear" in caught.value.diagnostics[0].help


@every_model
def test_the_check_finds_a_profile_that_misses_its_target(model: MotionModel) -> None:
    good = model.profile([0.5, 0.7], 0.4, 2.0)
    for what, spoil in [("durations", 1.001), ("accelerations", 1.001)]:
        changed = getattr(good, what).copy()
        changed[1, :] *= spoil
        parts = {"durations": good.durations, "accelerations": good.accelerations, what: changed}
        bad = Profile.build(good.moves, good.phases, jerks=good.jerks, problem=good.problem, **parts)
        assert bad.defects().tolist() == [False, True]
