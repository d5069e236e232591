"""What runtime parameters alone determine, once: proven, in C and from Python, and kept until a parameter changes."""

from __future__ import annotations

import pickle
from dataclasses import replace
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from phichain.emit.c.text import header
from phichain.errors import ArrayError, ProofError, UnsupportedError
from phichain.ir import evaluate, total_operations
from phichain.ir.nodes import Op
from phichain.lowering import lower_function
from phichain.lowering.preparation import Preparation, preparation
from phichain.mechanics import derive
from phichain.native.callables import Kept, make_callable
from phichain.native.signature import Argument, Signature
from phichain.pipeline import build
from phichain.proof import prove
from phichain.reference import reference
from phichain.scene import Scene
from phichain.system import System
from tests.generated.compiling import STRICT, printed_scene, run, selftest_program, write_all

prove_module = import_module("phichain.proof.prove")
OPEN: dict[str, Any] = {"mass": "runtime", "length": "runtime"}
KINDS: dict[str, dict[str, Any]] = {
    "half_way": {**OPEN, "links": 3, "com": "runtime", "gravity": "runtime", "actuated": "all"},
    "in_loops": {**OPEN, "links": 5, "com": "runtime", "code": "loops", "angles": "absolute", "damping": 0.1},
    "wagon": {"links": 2, "mass": "runtime", "length": 0.5, "com": 0.2, "base": "cart", "cart_mass": "runtime"},
    "in_space": {**OPEN, "links": 3, "space": "spatial", "base": "cart", "cart_mass": 1.0},
    "small": {**OPEN, "links": 2, "real": "float"},
    "pulled": {"links": 1, "mass": 1.0, "length": 1.0, "gravity": "runtime"},
}  # fmt: skip


def scene(kind: str, *more: str) -> Scene:
    return Scene(kind, want=["prepare", *more], **KINDS[kind])


@cache
def system(kind: str) -> System:
    return build(scene(kind, "forward_dynamics"))


def drawn(chain: Scene, seed: int = 1) -> tuple[dict[str, Any], list[Any]]:
    """Runtime parameters and a state, u with it."""
    rng = np.random.default_rng(seed)
    p = {name: rng.uniform(0.5, 1.5, shape or None) for name, shape in chain.runtime_shapes.items()}
    if "com" in p:
        p["com"] = p["length"] * rng.uniform(0.3, 0.7, chain.links)
    q, v = rng.uniform(-1, 1, chain.nq), rng.uniform(-1, 1, chain.nv)
    if not chain.is_planar:
        links = q[2:].reshape(-1, 3)
        q[2:] = (links / np.linalg.norm(links, axis=1)[:, None]).ravel()
        v[2:] = np.cross(v[2:].reshape(-1, 3), q[2:].reshape(-1, 3)).ravel()
    return p, [q, v, *([rng.uniform(-1, 1, chain.nu)] if chain.nu else [])]


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
def test_it_is_the_equations_of_motion_in_fifty_digits(kind: str) -> None:
    chain, (p, state) = scene(kind), drawn(scene(kind))
    if chain.real == "float":
        p, state = {k: np.float32(x) for k, x in p.items()}, [np.float32(x) for x in state]
    inputs = dict(zip(("q", "v", "u"), (x.tolist() for x in state), strict=False))
    exact = np.array(reference(chain, "forward_dynamics", inputs, params={k: np.asarray(x).tolist() for k, x in p.items()})["a"], float)
    within = (1e-5 if chain.real == "float" else 1e-14) * np.max(np.abs(exact))
    bound = system(kind).prepare(p)
    for found in (system(kind).forward_dynamics(*state, p=p), bound(*state)):
        assert np.max(np.abs(found - exact)) < within
    rows = [np.stack([x, -x]) for x in state]
    assert np.array_equal(system(kind).forward_dynamics(*rows, p=p)[0], bound(*state))
    assert np.array_equal(bound(*rows)[0], bound(*state))


@pytest.mark.parametrize("kind", ["half_way", "in_loops", "in_space", "small"])
def test_the_c_passes_its_self_test_and_every_warning(kind: str, tmp_path: Path) -> None:
    folder = write_all(scene(kind), tmp_path)
    told = run(selftest_program(folder, *STRICT, "-O1"))
    assert told.count("forward_dynamics_prepared") == (2 if kind == "in_loops" else 3) and "all passed" in told


def test_the_header_says_what_is_saved() -> None:
    chain = scene("half_way", "forward_dynamics")
    text = header(printed_scene(chain), {})
    made = preparation(derive(chain))
    before, at_a_state = made.operations
    assert f"half_way_real values[{made.size}];" in text and f" * {before} operations.\n" in text
    assert f" * {at_a_state} operations, straight-line code.\n" in text
    assert before + at_a_state == total_operations(lower_function(derive(chain), "forward_dynamics"))
    assert before > 30


@pytest.mark.parametrize("kind", KINDS)
def test_both_parts_together_are_the_program_to_the_last_bit(kind: str) -> None:
    chain = scene(kind)
    p, state = drawn(chain)
    given = {**p, **dict(zip(("q", "v", "u"), state, strict=False))}
    whole, plain = preparation(derive(chain)).whole, lower_function(derive(chain), "forward_dynamics", chain.code)  # type: ignore[arg-type]
    assert evaluate(whole, given)["a"].tolist() == evaluate(plain, given)["a"].tolist()


@pytest.mark.parametrize("kind", ["half_way", "in_loops", "in_space"])
def test_it_is_proven_against_the_lagrangian(kind: str) -> None:
    assert prove(scene(kind)).record["prepare"] == prove_module.EXACTLY


def test_a_wrong_part_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A quotient that is prepared, upside down."""

    def upside_down(model: Any) -> Preparation:
        made = preparation(model)
        body = list(made.whole.body)
        k = next(k for k, s in enumerate(body) if isinstance(s, Op) and s.kind == "div")
        body[k] = replace(body[k], args=body[k].args[::-1])  # type: ignore[union-attr]
        return replace(made, whole=replace(made.whole, body=tuple(body)))

    monkeypatch.setattr(prove_module, "preparation", upside_down)
    with pytest.raises(ProofError, match=r"half_way\.prepare: does not meet the Lagrangian"):
        prove(scene("half_way"))


def test_it_is_made_anew_when_a_value_changes_and_not_before() -> None:
    made: list[float] = []
    signature = Signature("f", "x_f", (Argument("q", (1,)),), (Argument("a", (1,)),), (Argument("mass", (2,)),), True, "prepared")
    call = make_callable(signature, lambda *_: None, lambda *_: None, np.dtype(float), Kept(lambda *_: made.append(1.0), 16))
    mass = np.array([1.0, 2.0])
    for _ in range(3):
        call([0.0], p={"mass": mass})
    call([0.0], p={"mass": [1.0, 2.0]})
    assert len(made) == 1
    mass[1] = 3.0
    call([0.0], p={"mass": mass})
    call(np.zeros((4, 1)), p={"mass": mass})
    assert len(made) == 2
    with pytest.raises(ArrayError, match="is not positive"):
        call([0.0], p={"mass": [1.0, -2.0]})
    call([0.0], p={"mass": mass})
    assert len(made) == 3, "memory of a call that broke off is let go"


def test_changed_parameters_change_the_motion() -> None:
    (p, state), chain = drawn(scene("half_way")), system("half_way")
    first = chain.forward_dynamics(*state, p=p)
    other = chain.forward_dynamics(*state, p=p | {"gravity": 2.0})
    assert np.max(np.abs(first - other)) > 0.1
    assert np.array_equal(chain.forward_dynamics(*state, p=p), first)
    assert np.array_equal(chain.prepare(p | {"gravity": 2.0})(*state), other)
    again = pickle.loads(pickle.dumps(chain))
    assert np.array_equal(again.prepare(p)(*state), first)


def test_what_is_missing_is_said() -> None:
    with pytest.raises(UnsupportedError) as caught:
        Scene("shut", 2, mass=1.0, length=1.0, want=["prepare"])
    assert str(caught.value) == (
        "functions.want: has nothing to prepare on a scene without runtime parameters, whose numbers are folded into the code "
        "(got 'prepare'); use \"forward_dynamics\", or make some number of the scene \"runtime\""
    )
    with pytest.raises(ArrayError, match=r"prepare\.p: the runtime parameters mass, length, com, gravity are missing"):
        system("half_way").prepare()
    p, state = drawn(scene("half_way"))
    with pytest.raises(ArrayError, match="this scene has no runtime parameters|p"):
        system("half_way").prepare(p)(*state, p=p)
