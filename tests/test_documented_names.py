"""Names that users' scripts import must outlive a new layout."""

import importlib
import pickle

import pytest

from olp.core.documented_names import DOCUMENTED, todays_name


@pytest.mark.parametrize("name", sorted(DOCUMENTED))
def test_a_documented_module_is_todays_module_under_its_old_name(name):
    module = importlib.import_module(name)
    assert module is importlib.import_module(DOCUMENTED[name])
    assert module.__spec__ is not None
    assert module.__spec__.name == DOCUMENTED[name]


def test_modules_within_documented_packages_are_not_loaded_twice():
    from olp.lint import run

    from olp.checks.lint import run as today

    assert run is today
    assert todays_name("olp.lint.run") == "olp.checks.lint.run"
    assert todays_name("olp.diagnosis.html.page") == "olp.reports.diagnosis.page"
    assert todays_name("olp.core.units") is None
    with pytest.raises(ModuleNotFoundError):
        importlib.import_module("olp.lint.nothing")


def test_classes_of_documented_names_are_pickled_under_todays():
    from olp.diagnostic import error

    finding = error("P001", "unexpected")
    assert pickle.loads(pickle.dumps(finding)) == finding
    assert type(finding).__module__ == "olp.core.diagnostic"
