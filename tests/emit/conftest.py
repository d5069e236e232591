"""Scenes for casadi.external, each compiled once for all files that ask for it."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from phichain.lowering.lower import lower
from phichain.mechanics import derive
from tests.emit.external_scenes import KINDS, STRICT, Built, run, write


@pytest.fixture(scope="session")
def build(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Built]:
    """Compiles the scene of a kind, once, with the strict flags."""
    made: dict[str, Built] = {}

    def build_kind(kind: str) -> Built:
        if kind not in made:
            scene, folder = KINDS[kind], tmp_path_factory.mktemp(kind)
            lowered = lower(derive(scene))
            files = write(scene, lowered, folder)
            run(folder, "cc", *STRICT, "-O1", "-fPIC", "-shared", *files, "-o", f"{scene.name}.so", "-lm")
            made[kind] = Built(scene, lowered, folder)
        return made[kind]

    return build_kind
