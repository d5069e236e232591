"""Taylor recurrences are proven as truncated power series, and no mutant of them passes.

A mutant that expands the same motion is no fault. Those are told by another arithmetic, 50 digits over more orders, and counted apart.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest
from mpmath import mp

from phichain.errors import ProofError
from phichain.ir.builder import ArrayRef, Builder
from phichain.lowering.algebra.vector import load, store, sub
from phichain.lowering.planar.joints import difference
from phichain.lowering.series import Series, planar_factor, series
from phichain.lowering.series.run import expand, expand_column
from phichain.lowering.series.spatial import rows
from phichain.lowering.series.spatial.side_by_side import expand_shared
from phichain.mechanics import Model, derive
from phichain.proof.identities.expansion import ORDERS
from phichain.proof.prove import prove_recurrences
from phichain.scene import Scene
from tests.lowering.taylor_oracle import EXACT, Row, gap, state
from tests.proof.mutations import mutants

PER_KIND = {"factor": 4, "order": 4, "columns": 1, "order_shared": 2, "outright": 6}
UNEVEN: dict[str, Any] = {"mass": [0.7, 1.9, 0.4], "length": [0.5, 1.3, 0.8], "space": "spatial"}
PLANAR: dict[str, Any] = {**UNEVEN, "space": "planar"}
CART: dict[str, Any] = {"base": "cart", "cart_mass": 0.9, "code": "loops"}
JOINTS: dict[str, Any] = {"stiffness": [2.0, 0.5, 1.5], "damping": [0.3, 0.1, 0.2]}
TWO: dict[str, Any] = {**UNEVEN, "mass": [0.7, 1.9], "length": [0.5, 1.3]}
RUBBED: dict[str, Any] = {"friction": 0.3, "friction_speed": 0.2, "cart_friction": 0.4, "cart_friction_speed": 0.3}
CHAINS = {
    scene.name: scene
    for scene in (
        Scene("tips", 3, **UNEVEN, want=("propagate",), variational=True),
        Scene("damped", 3, **UNEVEN, **CART, **JOINTS),
        Scene("coms", 3, **UNEVEN, **CART, com=[0.3, 0.9, 0.5]),
        Scene("planar", 3, **PLANAR, com=[0.3, 0.9, 0.5], actuated="all", want=("propagate",), variational=True),
        Scene("planar_damped", 3, **PLANAR, **CART, **JOINTS, com=[0.3, 0.9, 0.5], angles="absolute"),
        Scene("planar_sprung", 2, **{**PLANAR, "mass": [0.7, 1.9], "length": [0.5, 1.3]}, stiffness=[0.0, 0.5]),
        Scene("planar_resting", 1, mass=0.7, length=0.5, com=0.3, stiffness=2.0, rest_angle=0.3),
        Scene("planar_tips", 2, mass="runtime", length="runtime", actuated=[2], code="loops"),
        Scene("planar_one", 1, mass=0.7, length=0.5, com=0.3, want=("propagate",), variational=True),
        Scene("free_one", 1, mass=0.7, length=0.5, com=0.3, actuated=[1], armature=0.2, want=("propagate",)),
        Scene("geared", 3, **PLANAR, com=[0.3, 0.9, 0.5], armature=[0.4, 0.0, 0.2], actuated="all", want=("propagate",), variational=True),
        Scene("geared_cart", 2, mass=[0.7, 1.9], length=[0.5, 1.3], **CART, armature="runtime", damping=0.1, angles="absolute"),
        Scene("dry", 3, **PLANAR, com=[0.3, 0.9, 0.5], friction=[0.3, 0.2, 0.1], friction_speed=0.2, want=("propagate",), variational=True),
        Scene("dry_cart", 2, mass="runtime", length="runtime", **CART, cart_friction="runtime", cart_friction_speed=0.3, armature=0.1, angles="absolute"),
        Scene("geared_one", 1, mass=0.7, length=0.5, com=0.3, armature=0.2, want=("propagate",), variational=True),
        Scene("rubbed", 1, mass=0.7, length=0.5, space="spatial", **CART, damping=0.3, **RUBBED, want=("propagate",), variational=True),
        Scene("held", 2, **TWO, com=[0.3, 0.0], inertia=[0.1, 0.2], want=("propagate",), variational=True),
        Scene("runtime", 3, **{**UNEVEN, "mass": "runtime", "length": "runtime"}, **CART),
    )
}


def made(name: str) -> tuple[Model, Series]:
    model = derive(CHAINS[name])
    return model, series(model)


@pytest.mark.parametrize("name", CHAINS)
def test_recurrences_are_proven(name: str) -> None:
    found = prove_recurrences(*made(name))
    assert found.is_exact and f"{ORDERS} orders" in found.how


def changed(whole: Series) -> Iterator[tuple[str, Series]]:
    """Mutants of all Programs of a series."""
    for part, per_kind in PER_KIND.items():
        program = getattr(whole, part)
        for mutant in mutants(program, per_kind) if program is not None else ():
            yield f"{part}: {mutant.kind}", replace(whole, **{part: mutant.program})


def expanded(scene: Scene, of: Series) -> list[Row]:
    """Coefficients, those of trajectories side by side, and those of a column, in 50 digits."""
    at = state(scene, 2)
    with mp.workdps(60):
        rho = Fraction(3, 8)
        base = expand(of, EXACT, ORDERS + 3, at.q, at.v, at.u, rho, **at.params)
        found = list(base.state)
        if of.order_shared is not None:
            found += expand_shared(of, EXACT, ORDERS + 3, at.q, at.v, at.u, rho, **at.params)
        if of.outright is not None:
            made = EXACT.run(of.outright, {"held": base.held, "right": base.right[0], "slope": base.state[1]})
            found += [list(rows) for rows in made.values()]
        if of.columns is not None:
            found += expand_column(of, EXACT, base, at.v, [x * 0 for x in at.v]).state
        return found


def expands_the_same(scene: Scene, whole: Series, mutant: Series) -> bool:
    return gap(expanded(scene, mutant), expanded(scene, whole)) < 1e-40


@pytest.mark.long
@pytest.mark.parametrize("name", CHAINS)
def test_no_mutant_passes(name: str) -> None:
    model, whole = made(name)
    fates: Counter[str] = Counter()
    for kind, mutant in changed(whole):
        try:
            prove_recurrences(model, mutant)
        except ProofError as refusal:
            assert "\n" not in str(refusal) and "Traceback" not in str(refusal)
            fates["refused"] += 1
        else:
            assert expands_the_same(model.scene, whole, mutant), kind
            fates["no fault"] += 1
    # Of two links by moments half of the elimination meets nothing beyond the tip.
    assert fates["refused"] >= 50 and fates["no fault"] <= fates["refused"] // (2 if name == "held" else 5), fates


def _turned(builder: Builder, links: int, lost: ArrayRef, rest: ArrayRef) -> None:
    """What springs in space are bent further by, with the other sign."""
    store(rest, 0, load(lost, 0))
    for k in range(1, links):
        store(rest, k, sub(load(lost, k), load(lost, k - 1)))


def _left_out(builder: Builder, links: int, lost: ArrayRef, rest: ArrayRef) -> None:
    """The first joint's alone."""
    for k in range(links):
        store(rest, k, tuple(-entry if k == 0 else builder.lift(0) for entry in load(lost, k)))


@pytest.mark.parametrize("mutant", [_turned, _left_out])
def test_what_rounding_took_from_unit_vectors_is_held_to_springs(mutant: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    model = derive(Scene(f"bent{mutant.__name__}", 3, **UNEVEN, **JOINTS))
    monkeypatch.setattr(rows, "keep_rests", mutant)
    with pytest.raises(ProofError, match="accelerations of order 0"):
        prove_recurrences(model, series(model))


@pytest.mark.parametrize("part", ["sine", "cosine", "spring"])
def test_what_rounding_took_from_angles_is_held_to_their_derivative(part: str, monkeypatch: pytest.MonkeyPatch) -> None:
    model = derive(Scene(f"turned_{part}", 3, **PLANAR, **JOINTS, com=[0.3, 0.9, 0.5], angles="absolute"))
    whole = planar_factor.directions, planar_factor.rest_of_difference

    def directions(builder: Builder, scene: Scene, q: ArrayRef, lost: ArrayRef) -> tuple[ArrayRef, ArrayRef]:
        (sine, cosine), (near_sine, near_cosine) = whole[0](builder, scene, q, lost), builder.sincos(difference(builder, scene, "near", q), 3)
        return (near_sine, cosine) if part == "sine" else (sine, near_cosine)

    def rest(builder: Builder, scene: Scene, name: str, theta: ArrayRef, lost: ArrayRef) -> ArrayRef:
        found = builder.array(name, scene.links)
        for k in range(scene.links):
            found[k] = lost[k]
        return found

    monkeypatch.setattr(planar_factor, *(("rest_of_difference", rest) if part == "spring" else ("directions", directions)))
    with pytest.raises(ProofError, match="with what rounding took"):
        prove_recurrences(model, series(model))
