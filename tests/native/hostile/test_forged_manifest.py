"""A manifest is believed where its scene, the contract and the header of its C say the same, and nowhere else."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from phichain.emit import folder_files, library_files
from phichain.errors import CompilerError, OutputError
from phichain.lowering import lower
from phichain.mechanics import derive
from phichain.native import Cache, build_casadi, build_files, build_folder
from phichain.native.agreement import demand_agreement
from phichain.native.signature import manifest_of
from phichain.scene import Scene, load_scene, scene_from_dict
from phichain.scene.library import bundled_scenes

Edit = Callable[[dict[str, Any]], object]


def wide_chain(manifest: dict[str, Any]) -> None:
    """A chain of one link more, consistently, which the header has not."""
    manifest["scene"]["chain"]["links"] = 3
    manifest["scene"]["chain"]["length"] = [0.5, 0.5, 0.5]
    scene = scene_from_dict(manifest["scene"])
    manifest.update(digest=scene.digest, scene=scene.to_dict())
    manifest["params"][0]["shape"] = [3]
    for function in manifest["functions"].values():
        for argument in (*function["inputs"], *function["outputs"]):
            argument["shape"] = [3 if size == 2 else size for size in argument["shape"]]


def single(manifest: dict[str, Any]) -> None:
    """Single precision, consistently."""
    manifest["scene"]["target"]["real"] = manifest["real"] = "float"
    manifest["digest"] = scene_from_dict(manifest["scene"]).digest


FORGERIES: dict[str, Edit] = {
    "symbol of the C library": lambda m: m["functions"]["step"].update(symbol="system"),
    "symbol of another function": lambda m: m["functions"]["mass_matrix"].update(symbol="duo_energy"),
    "shorter output": lambda m: m["functions"]["mass_matrix"]["outputs"][0].update(shape=[2]),
    "output of one number": lambda m: m["functions"]["mass_matrix"]["outputs"][0].update(shape=[]),
    "longer input": lambda m: m["functions"]["step"]["inputs"][1].update(shape=[2**31]),
    "single precision": lambda m: m.update(real="float"),
    "single precision everywhere": single,
    "another scene": wide_chain,
    "a scene that is none": lambda m: m["scene"].update(chain=5),
    "another digest": lambda m: m.update(digest="0" * 64),
    "another name": lambda m: m.update(name="trio"),
    "order of parameters": lambda m: m["params"].reverse(),
    "size of a parameter": lambda m: m["params"][0].update(shape=[3]),
    "missing parameter": lambda m: m["params"].pop(),
    "missing argument": lambda m: m["functions"]["step"]["inputs"].pop(),
    "missing output": lambda m: m["functions"]["energy"]["outputs"].pop(),
    "struct that is not taken": lambda m: m["functions"]["linearization"].update(params=True),
    "struct that is not handed": lambda m: m["functions"]["step"].update(params=False),
    "missing function": lambda m: m["functions"].pop("step"),
    "function nobody wants": lambda m: m["functions"].update(coriolis=m["functions"]["step"]),
    "flow nobody wants": lambda m: m.update(flows={"propagate": {"symbol": "duo_propagate"}}),
    "flow that is none": lambda m: m.update(flows={"step": {"symbol": "duo_step"}}),
}


@pytest.mark.parametrize("forgery", FORGERIES)
def test_a_forged_manifest_is_refused_before_anything_is_compiled(folder: Path, cache: Cache, forgery: str) -> None:
    path = folder / "manifest.json"
    manifest = json.loads(path.read_text())
    FORGERIES[forgery](manifest)
    path.write_text(json.dumps(manifest))
    for make in (build_folder, build_casadi):
        with pytest.raises(OutputError) as caught:
            make(folder, cache=cache)
        assert str(folder) in str(caught.value)
    assert not cache.root.exists()


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("duo_real out[4]", "duo_real out[3]"),
        ("typedef double", "typedef float"),
        ("#define DUO_NQ 2", "#define DUO_NQ 3"),
        ("const duo_real u[2], duo_real a[2]", "duo_real a[2], const duo_real u[2]"),
        ("void duo_mass_matrix", "void duo_mass_matrices"),
        ("duo_real h,", "duo_real *h,"),
    ],
)
def test_a_header_that_says_something_else_is_refused(folder: Path, cache: Cache, old: str, new: str) -> None:
    header, path = folder / "duo.h", folder / "manifest.json"
    text = header.read_text()
    assert old in text
    header.write_text(text.replace(old, new))
    manifest = json.loads(path.read_text())
    manifest["files"]["duo.h"] = f"sha256:{hashlib.sha256(header.read_bytes()).hexdigest()}"
    path.write_text(json.dumps(manifest))
    with pytest.raises(OutputError, match="^manifest: says another"):
        build_folder(folder, cache=cache)


def test_further_keys_are_allowed(folder: Path, cache: Cache) -> None:
    path = folder / "manifest.json"
    manifest = json.loads(path.read_text())
    manifest["proof"] = {"step": "exact at 3 points"}
    path.write_text(json.dumps(manifest))
    assert build_folder(folder, cache=cache).has("step")


FLOWS = ("forward_dynamics", "propagate", "propagate_batch", "forward_dynamics_batch")


@pytest.mark.long
@pytest.mark.parametrize("field", ["int order;", "double lost[2];"])
def test_a_flow_s_struct_that_lies_otherwise_does_not_compile(tmp_path: Path, field: str) -> None:
    scene = Scene("flowing", 1, mass=1.0, length=1.0, want=FLOWS)
    files = library_files(scene, lower(derive(scene)))
    header = files["flowing.h"]
    where = header.index("typedef struct flowing_flow {") + len("typedef struct flowing_flow {")
    files["flowing.h"] = f"{header[:where]}\n    {field.replace('order', 'more').replace('lost', 'more')}{header[where:]}"
    manifest = json.loads(files["manifest.json"])
    manifest["files"]["flowing.h"] = f"sha256:{hashlib.sha256(files['flowing.h'].encode()).hexdigest()}"
    files["manifest.json"] = json.dumps(manifest)
    with pytest.raises(CompilerError):
        build_files(files, cache=Cache(tmp_path / "cache"))


def test_flows_are_called_by_the_symbols_of_their_c(tmp_path: Path) -> None:
    scene = Scene("flowing", 1, mass=1.0, length=1.0, want=FLOWS)
    files = library_files(scene, lower(derive(scene)))
    manifest = json.loads(files["manifest.json"])
    manifest["flows"]["propagate"]["symbol"] = "flowing_propagate_batch"
    with pytest.raises(OutputError, match=r"flows\.propagate\.symbol"):
        build_files({**files, "manifest.json": json.dumps(manifest)}, cache=Cache(tmp_path / "cache"))


@pytest.mark.long
@pytest.mark.parametrize("name", bundled_scenes())
def test_what_is_emitted_is_borne_out(name: str) -> None:
    scene = load_scene(bundled_scenes()[name])
    files = library_files(scene, lower(derive(scene)))
    assert demand_agreement(manifest_of({file: text.encode() for file, text in files.items()})) == scene


def test_a_whole_folder_is_borne_out() -> None:
    scene = Scene("one", 1, mass="runtime", length=1.0, want=FLOWS)
    files = folder_files(scene, lower(derive(scene)))
    assert demand_agreement(manifest_of({file: text.encode() for file, text in files.items()})) == scene
