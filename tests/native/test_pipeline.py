"""The verbs of the package on a scene, and on what is none."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from phichain import build, derive, generate, lower
from phichain.errors import DerivationError, SceneError
from phichain.native import Cache, build_casadi, build_folder
from phichain.scene import Scene


@pytest.mark.parametrize("verb", [derive, build, generate])
@pytest.mark.parametrize("given", ["scenes/paper_a_2.toml", None, 4])
def test_what_is_no_scene_is_refused_in_one_sentence(
    verb: Callable[[Any], Any], given: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SceneError, match=r"^scene: is not a Scene \(got .*\); load a file with load_scene"):
        verb(given)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("given", ["scenes/paper_a_2.toml", None, 4, Scene("pair", 2, mass=1.0, length=1.0)])
def test_what_is_no_model_is_not_lowered(given: Any) -> None:
    with pytest.raises(DerivationError, match=r"^model: is not a Model \(got .*\); write lower\(derive\(scene\)\)$"):
        lower(given)


def test_the_generated_casadi_c_compiles_with_the_functions_that_it_calls(tmp_path: Path) -> None:
    casadi = pytest.importorskip("casadi")
    scene = Scene("pair", 2, mass="runtime", length=[0.5, 0.4], com=[0.2, 0.3], actuated="all")
    folder, cache = generate(scene, tmp_path, with_casadi_c=True), Cache(tmp_path / "cache")
    q, v, u, mass = [0.4, -0.7], [1.1, 0.2], [0.3, -0.1], np.array([1.5, 0.8])
    external = casadi.external("pair_casadi_forward_dynamics", str(build_casadi(folder, cache=cache)))
    expected = build_folder(folder, cache=cache).forward_dynamics(q, v, u, p={"mass": mass})
    np.testing.assert_allclose(external(mass, q, v, u).full().ravel(), expected, rtol=1e-14)
