"""The verbs of the package on a scene, and on what is none."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from phichain import build, derive, generate, identity, lower, scratch
from phichain.errors import DerivationError, SceneError
from phichain.native import Cache, CacheWarning, build_casadi, build_folder
from phichain.native.warm import remember, texts_key
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


PAIR = Scene("pair", 2, mass=1.0, length=1.0, want=("forward_dynamics", "energy"))


@pytest.fixture
def kept(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Cache:
    """A cache that holds one proven build, after which nothing can be derived, lowered, proven or printed."""
    monkeypatch.setenv("PHICHAIN_CACHE", str(tmp_path / "cache"))
    build(PAIR)
    for step in ("derive", "lower", "proven", "library_files"):
        monkeypatch.setattr(scratch, step, _refused)
    return Cache(tmp_path / "cache")


class AnewError(Exception):
    """A step of generation was taken."""


def _refused(*_: Any) -> Any:
    raise AnewError


def test_what_is_built_is_found_without_a_step_of_generation(kept: Cache) -> None:
    for prove in (True, False):
        found = build(replace(PAIR), prove=prove)
        assert found.digest == PAIR.digest
        assert found.forward_dynamics([0.1, 0.2], [0.0, 0.0]).shape == (2,)
    with pytest.raises(AnewError):
        build(replace(PAIR, gravity=9.80665))


def test_a_process_that_finds_its_library_imports_no_symbols(kept: Cache) -> None:
    script = (
        "import sys; from phichain import Scene, build; "
        "build(Scene('pair', 2, mass=1.0, length=1.0, want=('forward_dynamics', 'energy'))); "
        "print(sorted({'sympy', 'jinja2', 'mpmath'} & sys.modules.keys()))"
    )
    paths = os.pathsep.join(str(Path(__file__).parents[2] / folder) for folder in ("codegen", "."))
    done = subprocess.run([sys.executable, "-c", script], env={**os.environ, "PYTHONPATH": paths}, capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_another_generator_writes_its_own(kept: Cache, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("phichain.native.warm.generator", lambda: "another")
    with pytest.raises(AnewError):
        build(PAIR)


def test_a_generator_is_known_by_its_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for folder in ("templates", "stencils"):
        (tmp_path / folder).mkdir()
    file = tmp_path / "a.py"
    file.write_text("one")
    monkeypatch.setattr(identity, "_PACKAGE", tmp_path)
    made = [identity.generator.__wrapped__()]
    file.write_text("other")
    made.append(identity.generator.__wrapped__())
    for name in ("templates/b.j2", "stencils/c.c"):
        (tmp_path / name).write_text("")
        made.append(identity.generator.__wrapped__())
    assert len(set(made)) == 4


def forged(texts: dict[str, str], **changes: Any) -> dict[str, str]:
    """Texts whose manifest says something else."""
    return {**texts, "manifest.json": json.dumps(json.loads(texts["manifest.json"]) | changes)}


FORGERIES: dict[str, Callable[[dict[str, str]], dict[str, str]]] = {
    "another function's C": lambda texts: {**texts, "pair.c": texts["pair.c"] + "\n"},
    "another header": lambda texts: {**texts, "pair.h": texts["pair.h"].replace("double", "float")},
    "nothing proven": lambda texts: forged(texts, proof={}),
    "no word on how": lambda texts: forged(texts, proof={"forward_dynamics": 1, "energy": 2}),
    "another scene's digest": lambda texts: forged(texts, digest="0" * 64),
    "no manifest": lambda texts: {"pair.c": texts["pair.c"]},
    "no texts": lambda texts: {"pair.c": 1},  # type: ignore[dict-item]
}


@pytest.mark.parametrize("forge", FORGERIES.values(), ids=FORGERIES)
def test_what_else_stands_for_a_scene_is_dropped_and_written_anew(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, forge: Callable[[dict[str, str]], dict[str, str]]
) -> None:
    monkeypatch.setenv("PHICHAIN_CACHE", str(tmp_path / "cache"))
    cache, texts = Cache(tmp_path / "cache"), scratch.library_texts(PAIR, prove=True)
    remember(PAIR, forge(texts), cache)
    with pytest.warns(CacheWarning, match=r"dropped the cache's texts of pair \(.*\); they are written again"):
        build(PAIR)
    assert build(PAIR).name == "pair"


def test_another_scene_s_texts_are_not_taken_for_it(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PHICHAIN_CACHE", str(tmp_path / "cache"))
    cache, heavy = Cache(tmp_path / "cache"), replace(PAIR, mass=2.0)
    key = texts_key(PAIR).encode()
    cache.store(key.decode(), key + zlib.compress(json.dumps(scratch.library_texts(heavy, prove=True)).encode()))
    with pytest.warns(CacheWarning, match="it is of another scene"):
        assert build(PAIR).digest == PAIR.digest
    cache.drop(key.decode())
    cache.store(key.decode(), key + b"no archive")
    with pytest.warns(CacheWarning, match="they are written again"):
        build(PAIR)
