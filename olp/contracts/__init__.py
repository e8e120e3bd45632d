"""Contract suites: what every member of a kind promises, one function per kind, as scikit-learn's `check_estimator`.

    from olp.contracts import check_vendor
    check_vendor(VENDOR)  # raises ContractError, which names promise, input and difference

This package stands above all others: it may import everything, and nothing imports it.
"""

from olp.contracts.commands import check_command
from olp.contracts.estimators import check_estimator
from olp.contracts.hosts import check_host
from olp.contracts.models import check_model
from olp.contracts.promises import BrokenPromise, ContractError
from olp.contracts.reports import check_report
from olp.contracts.robots import check_robot
from olp.contracts.terms import check_term
from olp.contracts.vendors import check_vendor
from olp.contracts.writers import check_writer

__all__ = [
    "BrokenPromise",
    "ContractError",
    "check_command",
    "check_estimator",
    "check_host",
    "check_model",
    "check_report",
    "check_robot",
    "check_term",
    "check_vendor",
    "check_writer",
]
