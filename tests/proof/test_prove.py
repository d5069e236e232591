"""The proof on the road: every committed scene is proven, generate and build refuse what is not, and the manifest says how."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import pytest
from typer.testing import CliRunner

from phichain import pipeline, scratch
from phichain.app.cli import app
from phichain.contract.functions import FLOWS, PLANAR_FUNCTIONS, SPATIAL_FUNCTIONS
from phichain.emit import library_files
from phichain.errors import ProofError
from phichain.ir.nodes import Op, walk
from phichain.lowering import Lowered, lower
from phichain.mechanics import Model, derive
from phichain.native import default_cache
from phichain.proof import EXACTLY, prove
from phichain.proof.case import IDENTITIES
from phichain.proof.identities.expansion import ORDERS
from phichain.scene import Scene, load_scene, standard_scene

ROOT = Path(__file__).parents[2]
COMMITTED = sorted(path.stem for path in (ROOT / "scenes").glob("*.toml"))
PAIR = Scene("pair", 2, mass=[0.3, 0.2], length=[0.5, 0.4], want=("forward_dynamics", "energy"))


@pytest.mark.long
@pytest.mark.parametrize("name", COMMITTED)
def test_every_committed_scene_is_proven(name: str) -> None:
    scene = load_scene(ROOT / "scenes" / f"{name}.toml")
    proof = prove(scene)
    assert {entry.name for entry in proof.functions} >= set(scene.want)
    assert set(proof.exact) == {entry.name for entry in proof.functions} - set(FLOWS)
    for entry in proof.functions:
        assert entry.how == EXACTLY if entry.name in proof.exact else entry.how.startswith("50 digits in the self-test: ")


@pytest.mark.long
@pytest.mark.parametrize("space", ["planar", "spatial"])
@pytest.mark.parametrize("base", ["fixed", "cart"])
@pytest.mark.parametrize("joints", ["free", "sprung", "damped"])
@pytest.mark.parametrize("numbers", ["given", "runtime"])
def test_every_kind_of_chain_is_proven(space: str, base: str, joints: str, numbers: str) -> None:
    functions = {"planar": PLANAR_FUNCTIONS, "spatial": SPATIAL_FUNCTIONS}[space]
    runtime = numbers == "runtime"
    scene = Scene(
        "chain", 2, space, base,
        mass="runtime" if runtime else [0.3, 0.2], length="runtime" if runtime else [0.5, 0.4],
        com=None if joints == "free" else "runtime" if runtime else [0.2, 0.1],
        cart_mass=None if base == "fixed" else "runtime" if runtime else 0.7,
        stiffness=None if joints == "free" else "runtime" if runtime else [1.0, 0.0],
        damping=[0.1, 0.2] if joints == "damped" else None,
        want=[name for name in (*functions, "momentum", "tensions") if not (joints == "damped" and name.startswith("phi"))],
    )  # fmt: skip
    proof = prove(scene)
    assert {entry.name for entry in proof.functions} - set(FLOWS) == set(proof.exact)


@pytest.mark.parametrize("base", ["fixed", "cart"])
@pytest.mark.parametrize("links", [1, 3])
def test_implicit_solves_with_masses_near_the_joints_are_proven(links: int, base: str) -> None:
    """In numbers known, so that the sweep is the one for r << l; with `runtime` it is among the chains above."""
    scene = Scene(
        "near", links, "spatial", base, mass=[0.3, 0.2, 0.5][:links], length=[0.5, 0.4, 0.3][:links],
        com=[0.001, 0.4, 0.02][:links], cart_mass=None if base == "fixed" else 0.7, want=("step_rosenbrock",),
    )  # fmt: skip
    assert {"implicit_factors", "implicit_solution"} < set(prove(scene).exact)


@pytest.mark.parametrize("angles", ["relative", "absolute", "adjacent"])
def test_every_kind_of_angle_is_proven_in_loops_too(angles: str) -> None:
    scene = replace(standard_scene(4), angles=angles, code="loops", base="cart", cart_mass=1.5)
    assert len(prove(scene).exact) == len([name for name in scene.want if name not in FLOWS])


def test_every_function_of_the_contract_that_is_a_rational_map_has_an_identity() -> None:
    iterations = {"step_lie4", "step_variational", "step_rosenbrock"}
    for space, functions in (("planar", PLANAR_FUNCTIONS), ("spatial", SPATIAL_FUNCTIONS)):
        for name in {*functions, "momentum", "tensions"} - set(FLOWS) - iterations:
            assert IDENTITIES.has(name, space), name


def test_the_points_follow_from_the_scene_and_the_outcome_is_the_same_text() -> None:
    assert prove(PAIR) == prove(PAIR)
    assert dict(prove(PAIR).record) == {"forward_dynamics": EXACTLY, "energy": EXACTLY}
    assert "seconds" not in json.dumps(dict(prove(PAIR).record))
    with pytest.raises(ProofError) as one:
        prove(wrong(derive(PAIR)).model, wrong(derive(PAIR)))
    assert one.value.digest == PAIR.digest


def wrong(model: Model) -> Lowered:
    """The Programs of a Model with the first subtraction of the forward dynamics turned into an addition."""
    lowered = lower(model)
    program = lowered.wanted["forward_dynamics"]
    first = next(s for s in walk(program.body) if isinstance(s, Op) and s.kind == "sub")
    body = tuple(replace(s, kind="add") if s is first else s for s in program.body)
    wanted = {**lowered.wanted, "forward_dynamics": replace(program, body=body)}
    return replace(lowered, wanted=MappingProxyType(wanted))


@pytest.fixture
def faulty(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A generator whose forward dynamics has one wrong sign, and a cache of its own."""
    monkeypatch.setattr(scratch, "lower", wrong)
    monkeypatch.setenv("PHICHAIN_CACHE", str(tmp_path / "cache"))


SENTENCE = r"^pair\.forward_dynamics: does not meet the Lagrangian at random point 1 \(got 'a\[0\]'\); nothing was written"


def test_generate_refuses_in_one_sentence_and_leaves_what_was_there(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    folder = pipeline.generate(PAIR, tmp_path / "out")
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    monkeypatch.setattr(scratch, "lower", wrong)
    for out in ("out", "other"):
        with pytest.raises(ProofError, match=SENTENCE) as refusal:
            pipeline.generate(PAIR, tmp_path / out)
        assert (refusal.value.function, refusal.value.point) == ("forward_dynamics", 1)
        assert "\n" not in str(refusal.value)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    assert not (tmp_path / "other").exists()


def test_build_refuses_whether_it_was_built_unproven_before_or_not(faulty: None) -> None:
    with pytest.raises(ProofError, match=SENTENCE):
        pipeline.build(PAIR)
    assert pipeline.build(PAIR, prove=False).name == "pair"
    with pytest.raises(ProofError, match=SENTENCE):
        pipeline.build(PAIR)


def test_a_build_that_was_proven_is_not_proven_again(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PHICHAIN_CACHE", str(tmp_path / "cache"))
    runs: list[str] = []

    def counted(model: Model, lowered: Lowered):  # type: ignore[no-untyped-def]
        runs.append(model.scene.name)
        return prove(model, lowered)

    monkeypatch.setattr(scratch, "proven", counted)
    for _ in range(2):
        pipeline.build(PAIR)
    assert runs == ["pair"]
    pipeline.build(replace(PAIR, gravity=9.80665))
    assert runs == ["pair", "pair"]


@pytest.mark.filterwarnings("ignore::phichain.native.cache.CacheWarning")
@pytest.mark.parametrize(
    "content",
    [b"", b"[", b"null", b"[" * 10_000, b'{"proof": {}}', b'{"key": "KEY"}', b'{"key": "KEY", "proof": {"energy": 1}}', b"\x7fELF"],
)
def test_what_else_lies_under_a_proof_s_key_is_proven_again(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, content: bytes
) -> None:
    monkeypatch.setenv("PHICHAIN_CACHE", str(tmp_path / "cache"))
    key = scratch._proof_key(PAIR, library_files(PAIR, lower(derive(PAIR))))
    default_cache().store(key, content.replace(b"KEY", key.encode()))
    runs: list[str] = []

    def counted(model: Model, lowered: Lowered):  # type: ignore[no-untyped-def]
        runs.append(model.scene.name)
        return prove(model, lowered)

    monkeypatch.setattr(scratch, "proven", counted)
    assert pipeline.build(PAIR).name == "pair"
    assert runs == ["pair"]


def test_the_manifest_says_of_every_function_how_it_was_proven_or_that_it_was_not(tmp_path: Path) -> None:
    scene = replace(PAIR, want=("forward_dynamics", "step", "propagate"))

    def recorded(is_proven: bool) -> dict[str, str]:
        folder = pipeline.generate(scene, tmp_path, prove=is_proven)
        return dict(json.loads((folder / "manifest.json").read_text())["proof"])

    assert recorded(True) == {
        "forward_dynamics": EXACTLY,
        "step": EXACTLY,
        "propagate": f"50 digits in the self-test: steps in floating point; its recurrences {EXACTLY}, {ORDERS} orders",
    }
    assert recorded(False) == dict.fromkeys(scene.want, "not proven: the proof was switched off")


def test_the_command_prints_a_line_for_every_function() -> None:
    done = CliRunner().invoke(app, ["prove", "paper_a_2"])
    assert done.exit_code == 0
    lines = done.stdout.splitlines()
    assert lines[0].split() == ["forward_dynamics", *EXACTLY.split()]
    assert lines[-1].startswith("paper_a_2: 12 proven exactly, 1 by other means, ")
    assert len(lines) == 14
