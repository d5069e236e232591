"""Derivatives of a motion by runtime parameters: recurrences proven, and columns against the un-lowered Lagrangian in 50 digits."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

from phichain.emit.selftest.flow import exact_motion
from phichain.errors import ArrayError, ProofError, SceneError, UnsupportedError
from phichain.ir.nodes import Const, Store
from phichain.lowering.series import series
from phichain.mechanics import derive
from phichain.pipeline import build
from phichain.proof.prove import prove_recurrences
from phichain.scene import Scene, scene_from_dict
from phichain.system.variations import variations
from tests.flow.flows import compiled

R = "runtime"
CHAIN: dict[str, Any] = {"links": 3, "mass": R, "length": R, "want": ["propagate"]}
TIED: dict[str, Any] = {"stiffness": R, "damping": R}
ALL: dict[str, Any] = {"variational": ["mass", "length"]}
VARIED = {
    scene.name: scene
    for scene in (
        Scene("tips", **CHAIN, **ALL),
        Scene("forced", **CHAIN, com=R, variational=["mass", "length", "com"], forced=2),
        Scene("cart", **CHAIN, **TIED, com=R, variational=["mass", "cart_mass", "stiffness", "damping"], forced="cart", base="cart",
              cart_mass=R, angles="absolute"),
        Scene("geared", **CHAIN, gravity=R, armature=R, damping=0.1, variational=["mass", "length", "gravity", "armature"]),
        Scene("rests", **CHAIN, stiffness=R, rest_angle=R, actuated="all", variational=["mass", "rest_angle", "stiffness"]),
        Scene("rods", **CHAIN, com=0.2, inertia=R, variational=["mass", "inertia"]),
        Scene("one", **{**CHAIN, "links": 1}, **TIED, rest_angle=R, variational=["mass", "length", "stiffness", "rest_angle", "damping"], forced=1),
        Scene("space", **CHAIN, stiffness=R, space="spatial", variational=["mass", "length", "stiffness"]),
        Scene("space_coms", **CHAIN, **TIED, com=R, base="cart", cart_mass=R, cart_damping=R, space="spatial",
              variational=["mass", "com", "cart_mass", "cart_damping", "damping"]),
        Scene("space_shaken", **CHAIN, com=R, base="moving", forced="base", axis=3, space="spatial", variational=["mass", "com"]),
        Scene("loops", **{**CHAIN, "links": 6}, com=0.3, **ALL, code="loops", forced=3),
        Scene("driven_alone", 2, mass=1.0, length=0.5, want=["propagate"], forced=1, variational=["forcing"]),
    )
}  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("name", VARIED)
def test_derivatives_by_parameters_are_proven(name: str) -> None:
    model = derive(VARIED[name])
    assert prove_recurrences(model, series(model)).is_exact


@pytest.mark.long
@pytest.mark.parametrize(("part", "output"), [("factor_along", "d_held"), ("order_along", "d_next"), ("factor_along", "d_later")])
def test_a_derivative_left_out_is_refused(part: str, output: str) -> None:
    """All but those of numbers that no order, or none behind the first, takes part in."""
    model = derive(Scene("mutated", 2, mass=R, length=R, com=R, want=["propagate"], variational=["mass", "length", "com"], forced=2))
    whole = series(model)
    program, refused, passed = getattr(whole, part), 0, 0
    for i, statement in enumerate(program.body):
        if not isinstance(statement, Store) or statement.cell.array != output or statement.value == Const(Fraction(0)):
            continue
        body = list(program.body)
        body[i] = replace(statement, value=Const(Fraction(0)))
        try:
            prove_recurrences(model, replace(whole, **{part: replace(program, body=tuple(body))}))
        except ProofError as refusal:
            assert "derivative by parameters" in str(refusal)
            refused += 1
        else:
            passed += 1
    assert refused >= (4 if part == "order_along" else 10) and passed <= refused // 2, (refused, passed)


VALUES: dict[str, Any] = {
    "mass": [0.75, 1.5, 0.5], "length": [0.5, 1.25, 0.75], "com": [0.25, 1.0, 0.5], "stiffness": [2.0, 0.5, 1.5], "damping": [0.25, 0.125, 0.25],
    "cart_mass": 0.875, "cart_damping": 0.5, "gravity": 9.75, "rest_angle": [0.125, 0.25, -0.5],
}  # fmt: skip
FORCING = {"amplitude": 3.0, "omega": 7.0}


@pytest.mark.long
@pytest.mark.parametrize("name", ["cart", "one"])
def test_columns_are_differences_of_the_lagrangians_motions(name: str) -> None:
    scene, t_end, h = VARIED[name], 0.01, mpf("1e-6")
    p = {key: VALUES[key][: scene.links] if shape else VALUES[key] for key, shape in scene.runtime_shapes.items()}
    q, v, u = start(scene)
    size, total = scene.nq + scene.nv, sum(scene.varied.values())
    forcing = {key: FORCING[key] for key in scene.varied if key in FORCING}

    def exact(key: str, i: int, by: Any) -> np.ndarray:
        moved = {k: [mpf(x) + (by if (k, j) == (key, i) else 0) for j, x in enumerate(np.atleast_1d(x))] for k, x in (p | forcing).items()}
        params = {k: moved[k] if shape else moved[k][0] for k, shape in scene.runtime_shapes.items()}
        inputs = {"q": q, "v": v, "u": u} | {k: moved[k] for k in forcing}
        with mp.workdps(50):
            end = exact_motion(scene, params, inputs, t_end)
        assert end is not None
        return np.array([*end["q"], *end["v"]])

    entries = [(key, i) for key, count in scene.varied.items() for i in range(count)]
    start_columns, along, first = np.zeros((size, total)), {}, 0
    for key, count in scene.varied.items():
        along[key] = np.eye(count, total, first)
        first += count
    options = {"forcing": tuple(FORCING.values())} if forcing else {}
    found = compiled(scene)(q, v, 0.0, t_end, 1e-15, u=u or None, transition=start_columns, along=along, p=p, **options)
    for column in {0, len(entries) // 2, len(entries) - 1}:
        key, i = entries[column]
        slope = np.array((exact(key, i, h) - exact(key, i, -h)) / (2 * h), float)
        np.testing.assert_allclose(found.transition[:, column], slope, rtol=1e-9, atol=1e-12 * np.abs(slope).max() + 1e-15, err_msg=f"{key}[{i}]")


@pytest.mark.long
def test_columns_on_the_sphere_and_in_loops() -> None:
    """Where the ends of a call are other vectors than the recurrences', and where Programs are loops: differences of the flow."""
    for name, key, options in (("space", "stiffness", {}), ("loops", "length", {"forcing": (3.0, 7.0)})):
        scene, h = VARIED[name], 1e-5
        p = {k: np.resize(VALUES[k], scene.links) for k in scene.runtime}
        q, v, _ = start(scene) if name == "space" else ([0.3, -0.5, 0.7, 0.2, 0.1, 0.4], [0.8, 0.5, -0.4, 0.3, 0.2, 0.1], [])
        propagate, along = compiled(scene), {key: np.eye(scene.links)[:, :2]}
        size = scene.nq + scene.nv
        found = propagate(q, v, 0.0, 0.8, 1e-14, transition=np.zeros((size, 2)), along=along, p=p, **options)
        for i in range(2):
            step = np.eye(scene.links)[i] * h
            ends = [propagate(q, v, 0.0, 0.8, 1e-15, p={**p, key: p[key] + s * step}, **options) for s in (1, -1)]
            slope = (np.r_[ends[0].q, ends[0].v] - np.r_[ends[1].q, ends[1].v]) / (2 * h)
            np.testing.assert_allclose(found.transition[:, i], slope, rtol=0, atol=2e-8 * np.abs(slope).max())


def start(scene: Scene) -> tuple[list[float], list[float], list[float]]:
    u = [0.25, -0.5, 0.125, 0.5][: scene.nu]
    if scene.is_planar:
        return [0.3, -0.5, 0.7, 0.2][: scene.nq], [0.8, 0.5, -0.4, 0.3][: scene.nq], u
    directions = np.array([[0.6, 0.0, 0.8], [0.0, 0.6, 0.8], [0.28, 0.0, 0.96]])
    rates = np.cross(directions, [[0.2, 0.5, 0.1], [0.3, 0.1, 0.4], [0.5, 0.2, 0.1]])
    cart = 2 * scene.has_cart
    return [0.1] * cart + directions.ravel().tolist(), [0.2] * cart + rates.ravel().tolist(), u


@pytest.fixture(scope="module")
def system() -> Any:
    return build(
        Scene("varied_pair", 2, mass=R, length=R, damping=0.1, forced=1, want=["propagate"], variational=["mass", "length"])
    )


def test_a_long_run_and_directions_of_all_at_once(system: Any) -> None:
    """Whole columns in one call; a direction is their combination; the state's own are what they are without parameters."""
    p, x, options = {"mass": [0.7, 1.9], "length": [0.5, 1.3]}, ([0.3, -0.5], [0.2, 0.1]), {"forcing": (2.0, 4.0)}
    transition, along = variations(system, "mass", "length", "amplitude", "omega")
    whole = system.propagate(*x, 0.5, 4.5, 1e-14, transition=transition, along=along, p=p, **options)
    plain = system.propagate(*x, 0.5, 4.5, 1e-14, transition=np.eye(4), p=p, **options)
    np.testing.assert_allclose(whole.transition[:, :4], plain.transition, rtol=0, atol=1e-11)
    one = system.propagate(
        *x, 0.5, 4.5, 1e-14, transition=np.zeros((4, 1)), along={"mass": [[1.0], [2.0]], "omega": [3.0]}, p=p, **options
    )
    mixed = whole.transition[:, 4] + 2 * whole.transition[:, 5] + 3 * whole.transition[:, 9]
    np.testing.assert_allclose(one.transition[:, 0], mixed, rtol=0, atol=1e-10)
    h = 1e-5
    ends = [system.propagate(*x, 0.5, 4.5, 1e-15, p={**p, "length": [0.5 + s, 1.3]}, **options) for s in (h, -h)]
    slope = (np.r_[ends[0].q, ends[0].v] - np.r_[ends[1].q, ends[1].v]) / (2 * h)
    np.testing.assert_allclose(whole.transition[:, 6], slope, rtol=1e-7, atol=1e-7)


def test_what_cannot_be_carried(system: Any) -> None:
    call: Any = lambda **more: system.propagate([0.1, 0.2], [0.0, 0.0], 0.0, 1.0, 1e-12, forcing=(0, 1), p={"mass": [1, 1], "length": [1, 1]}, **more)
    with pytest.raises(ArrayError, match="is given without columns"):
        call(along={"mass": [[1.0], [0.0]]})
    with pytest.raises(ArrayError, match="is nothing that the flow carries derivatives by .*; use mass, length, amplitude, omega"):
        call(transition=np.eye(4), along={"masses": 1.0})
    with pytest.raises(ArrayError, match=r"must have shape \(2, 4\)"):
        call(transition=np.eye(4), along={"mass": [1.0, 2.0]})
    with pytest.raises(UnsupportedError, match="carries derivatives by: it varies mass, length, amplitude, omega"):
        variations(system, "gravity")


@pytest.mark.parametrize(
    ("names", "words"),
    [
        (["gravity"], 'asks for derivatives by a parameter that is no argument (got \'gravity\'); set chain.gravity = "runtime"'),
        (["forcing"], "asks for derivatives by a forcing, and nothing is forced (got 'forcing'); add [forcing]"),
        (["omega"], "is half of what forces a chain (got 'omega'); use [forcing] first"),
        (["masss"], 'is nothing that derivatives are by (got \'masss\'); use state, mass (did you mean "mass"?)'),
    ],
)
def test_what_derivatives_are_not_by(names: list[str], words: str) -> None:
    with pytest.raises(SceneError) as caught:
        Scene("pair", 2, mass=R, length=1.0, want=["propagate"], variational=names)
    assert words in str(caught.value)


def test_the_state_alone_is_true_and_all_survive_the_file() -> None:
    base: dict[str, Any] = {"mass": R, "length": 1.0, "want": ["propagate"]}
    assert Scene("pair", 2, **base, variational=["state"]) == Scene("pair", 2, **base, variational=True)
    assert Scene("pair", 2, **base, variational=[]) == Scene("pair", 2, **base)
    scene = Scene("pair", 2, **base, variational=["mass"])
    assert scene.variational == ("state", "mass") and scene_from_dict(scene.to_dict()) == scene
