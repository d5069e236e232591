"""What all tests share: the option that refreshes goldens, and Hypothesis without a clock."""

from __future__ import annotations

import os

import pytest
from hypothesis import HealthCheck, settings

# A shared machine is slow at times: examples are judged by their answers, never by seconds. In CI they are the same
# every time, so that a red run can be repeated; elsewhere they are fresh, so that somebody finds the next one.
settings.register_profile("phichain", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("ci", settings.get_profile("phichain"), derandomize=True, print_blob=True)
settings.load_profile("ci" if os.environ.get("CI") else "phichain")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--update", action="store_true", help="write the goldens anew instead of comparing with them")


#: Files that take longest, to be handed out first: with --dist loadfile a long one that comes last keeps one worker waiting.
LONG = (
    "generated/test_processors.py", "selftest/test_selftest_program.py", "generated/test_strict_c.py", "generated/test_bad_input.py",
    "lowering/test_forms.py", "cli/test_commands.py", "proof/test_mutants.py", "flow/test_batch_flow.py",
)  # fmt: skip


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Long files first; otherwise the order stays."""
    items.sort(key=lambda item: not item.path.as_posix().endswith(LONG))


@pytest.fixture(scope="session")
def update(request: pytest.FixtureRequest) -> bool:
    """Whether goldens are to be written instead of compared."""
    return bool(request.config.getoption("--update"))
