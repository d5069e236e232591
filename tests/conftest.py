"""What all tests share: the option that refreshes goldens, and Hypothesis without a clock."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from phichain.pipeline import generate
from phichain.scene import Scene

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
    "lowering/planar/test_forms.py", "cli/test_commands.py", "proof/test_mutants.py", "flow/batch/test_batch_flow.py",
)  # fmt: skip


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Long files first; otherwise the order stays."""
    items.sort(key=lambda item: not item.path.as_posix().endswith(LONG))


@pytest.fixture(scope="session")
def update(request: pytest.FixtureRequest) -> bool:
    """Whether goldens are to be written instead of compared."""
    return bool(request.config.getoption("--update"))


@pytest.fixture(scope="session")
def generated_once(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Scene], Path]:
    """The whole folder of a scene, unproven, written once for all workers of a session: to be read or copied, not changed."""
    base = tmp_path_factory.getbasetemp()
    shared = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "generated_once"

    def folder(scene: Scene) -> Path:
        place = shared / scene.digest
        place.mkdir(parents=True, exist_ok=True)
        with (shared / f"{scene.digest}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)  # one writes it, the other waits
            return place / scene.name if (place / scene.name).exists() else generate(scene, place, prove=False)

    return folder
