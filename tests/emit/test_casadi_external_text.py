"""NAME_casadi.c as text: side by side with other scenes, of every kind, refused in single precision, the same each time."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from phichain.emit.casadi.external import casadi_external
from phichain.emit.printed import print_scene
from phichain.errors import UnsupportedError
from phichain.lowering.lower import lower
from phichain.mechanics import derive
from phichain.scene import standard_scene
from tests.emit.casadi_scenes import SCENES, make_scene, relative_error
from tests.emit.external_scenes import STRICT, run, write

casadi = pytest.importorskip("casadi")
pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")


def test_several_scenes_share_one_shared_object(tmp_path: Path) -> None:
    scenes = [make_scene(name, 2, want=("forward_dynamics", "energy")) for name in ("left", "right")]
    files = [file for scene in scenes for file in write(scene, lower(derive(scene)), tmp_path)]
    run(tmp_path, "cc", *STRICT, "-O0", "-fPIC", "-shared", *files, "-o", "both.so", "-lm")
    both = [casadi.external(f"{s.name}_casadi_forward_dynamics", str(tmp_path / "both.so")) for s in scenes]
    assert relative_error(both[0]([0.1, 0.2], [0, 0]).full(), both[1]([0.1, 0.2], [0, 0]).full()) == 0


def test_each_kind_of_scene_compiles(tmp_path: Path) -> None:
    for scene in SCENES[::5]:
        small = replace(scene, want=("mass_matrix", "linearization"))
        files = write(small, lower(derive(small)), tmp_path)
        run(tmp_path, "cc", *STRICT, "-O0", "-c", *files)


def test_single_precision_is_refused() -> None:
    scene = replace(standard_scene(2), real="float")
    with pytest.raises(UnsupportedError) as caught:
        casadi_external(print_scene(scene, lower(derive(scene))))
    assert str(caught.value) == (
        "real: CasADi calls functions in double precision (got 'float'); "
        'set target.real = "double", or use planar2_casadi.py'
    )


def test_the_same_scene_gives_the_same_text() -> None:
    scene = make_scene("again", 2, want=("forward_dynamics", "mass_matrix"), gravity="runtime")
    first = casadi_external(print_scene(scene, lower(derive(scene))))
    assert first == casadi_external(print_scene(scene, lower(derive(scene))))
    assert all(line == line.rstrip() for line in first.splitlines())
    assert first.endswith("}\n")
    assert not re.search(r"\b(malloc|calloc|alloca|free)\b", first)
