"""The compiled chains of both papers, once per session and in a cache of their own."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from phichain.papers.figures import FIG_2, FIG_3, FIG_4, paper_a_chain, paper_a_wave, run_on_cart
from phichain.pipeline import build
from phichain.scene.library import find_scene
from phichain.system import System

pytest.importorskip("matplotlib")


@pytest.fixture(scope="session", autouse=True)
def _own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PHICHAIN_CACHE", str(tmp_path_factory.mktemp("cache") / "phichain"))
        yield


@pytest.fixture(scope="session")
def cart() -> System:
    return build(find_scene("paper_b"))


@pytest.fixture(scope="session")
def runs(cart: System) -> dict:
    """Figs 2, 3 and 4 of paper B as they are drawn: name -> (trajectory, gains)."""
    cases = {"B2": (FIG_2, 1e-12), "B3": (FIG_3, 1e-9), "B4": (FIG_4, 1e-9)}
    return {name: run_on_cart(cart, run, tol) for name, (run, tol) in cases.items()}


@pytest.fixture(scope="session")
def single() -> tuple:
    """Fig. 3: one link, its system and its signals."""
    system = paper_a_chain(1)
    return system, paper_a_wave(system)


@pytest.fixture(scope="session", params=["relative", "adjacent"])
def wave(request: pytest.FixtureRequest) -> tuple:
    """Fig. 5: three links in both readings of the angles."""
    system = paper_a_chain(3, request.param)
    return system, paper_a_wave(system)
