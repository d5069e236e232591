"""The reference of long chains: both routes to the accelerations agree, the second is believed in nothing, and all costs grow with N."""

from __future__ import annotations

import random
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from types import FrameType
from typing import Any

import pytest
from mpmath import fdot, mp, mpf

from phichain.errors import ConvergenceError
from phichain.reference import algebra, inertia, reference
from phichain.reference.case import Case
from phichain.reference.elimination import Row, factored
from phichain.reference.inertia import Inertia
from phichain.reference.pose import exact, parameters
from phichain.scene import Scene
from tests.reference_cases import flat

LINKS = 7

KINDS: dict[str, dict[str, Any]] = {
    "relative": {"inner": 0.3, "stiffness": 2.0, "damping": 0.1, "actuated": "all"},
    "absolute on a cart": {"angles": "absolute", "base": "cart", "cart_mass": 0.7, "actuated": "cart"},
    "adjacent on a cart": {"angles": "adjacent", "base": "cart", "cart_mass": 0.7, "inner": 0.2},
    "spatial": {"space": "spatial", "inner": 0.3, "stiffness": 2.0, "damping": 0.1},
    "spatial on a cart": {"space": "spatial", "base": "cart", "cart_mass": 0.7, "actuated": "cart"},
}
kinds = pytest.mark.parametrize("kind", KINDS.values(), ids=list(KINDS))


def chain(kind: dict[str, Any], links: int = LINKS) -> Scene:
    """Masses over six decades, lengths over three."""
    source = random.Random(links)
    mass = [10 ** source.uniform(-4, 2) for _ in range(links)]
    length = [10 ** source.uniform(-1, 2) for _ in range(links)]
    return made(kind, mass, length)


def made(kind: dict[str, Any], mass: list[float], length: list[float]) -> Scene:
    """A scene of a kind, each mass at the fraction `inner` of its link."""
    named = {name: value for name, value in kind.items() if name != "inner"}
    com = [kind.get("inner", 1.0) * entry for entry in length]
    return Scene("chain", len(mass), **named, mass=mass, length=length, com=com)


def state(scene: Scene) -> dict[str, list[float]]:
    source = random.Random(scene.name)
    sizes = {"q": scene.nq, "v": scene.nv, "q_dot": scene.nq, "u": scene.nu, "a": scene.nv}
    return {name: [source.uniform(-2, 2) for _ in range(size)] for name, size in sizes.items()}


def at(scene: Scene) -> Case:
    return Case(scene, parameters(scene), {name: list(map(exact, given)) for name, given in state(scene).items()})


def distance(found: list[Any], true: list[Any]) -> Any:
    return max(abs(a - b) for a, b in zip(found, true, strict=True)) / max(map(abs, true))


@pytest.mark.parametrize(
    ("kind", "function"),
    [
        *((kind, function) for kind in KINDS for function in ("forward_dynamics", "step_variational")),
        *((kind, "direction_dynamics") for kind in KINDS if "spatial" in kind),
        *((kind, "state_jacobian") for kind in KINDS if "spatial" not in kind),
    ],
)
def test_elimination_in_positions_gives_what_the_matrix_gives(
    kind: str, function: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = chain(KINDS[kind])
    inputs: dict[str, Any] = state(scene) | {"h": 1e-4}
    found = []
    for most in (10**6, 0):
        monkeypatch.setattr(inertia, "DENSE", most)
        found.append(reference(scene, function, inputs))
    with mp.workdps(50):
        for output, true in found[0].items():
            if isinstance(true, list) and all(true):
                assert distance(flat(found[1][output]), flat(true)) < mpf(10) ** -48, output


@kinds
def test_the_written_matrix_is_that_of_the_positions(kind: dict[str, Any]) -> None:
    """J^T m J with J from central differences of the positions that `reference` itself gives."""
    scene = chain(kind, 3)
    case = at(scene)
    carts = scene.has_cart * (1 if scene.is_planar else 2)
    with mp.workdps(110):
        pose, h = case.pose(), mpf(10) ** -30
        count = len(Inertia(scene, case.values, pose).written())

        def places(direction: int, way: int) -> list[Any]:
            q = [mpf(entry) for entry in case.inputs["q"]]
            if scene.is_planar or direction < carts:
                q[direction] += way * h
            else:
                link, axis = divmod(direction - carts, 2)
                first = carts + 3 * link
                turn = algebra.cross(pose.axes[link][axis], pose.direction[link])
                q[first : first + 3] = [a + way * h * b for a, b in zip(pose.direction[link], turn, strict=True)]
            return [x for place in reference(scene, "positions", {"q": q}, 100)["r"] for x in place]

        columns = [[(a - b) / (2 * h) for a, b in zip(places(i, 1), places(i, -1), strict=True)] for i in range(count)]
        size = len(columns[0]) // scene.links
        weights = [mpf(case.values.mass[i // size]) for i in range(len(columns[0]))]
        true = [[fdot([w * x for w, x in zip(weights, a, strict=True)], b) for b in columns] for a in columns]
        for axis in range(carts):
            true[axis][axis] += case.values.cart_mass
        for row, expected in zip(Inertia(scene, case.values, pose).written(), true, strict=True):
            assert distance(row, expected) < mpf(10) ** -25


@pytest.mark.parametrize("fault", ["a sign", "a length", "a mass", "an axis"])
@kinds
def test_a_wrong_system_is_found_out(kind: dict[str, Any], fault: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """What the elimination solves is only a guess: where it is wrong, its answer leaves more than round-off of the forces."""
    scene, true = chain(kind), inertia._rows

    def rows(system: Inertia) -> list[Row]:
        values = system.values
        match fault:
            case "a sign":
                made = true(system)
                made[len(made) // 2] = {column: -entry if column % 2 else entry for column, entry in made[len(made) // 2].items()}
                return made
            case "a length":
                return true(replace(system, values=replace(values, length=[values.length[0] * 2, *values.length[1:]])))
            case "a mass":
                return true(replace(system, values=replace(values, mass=[*values.mass[:-1], values.mass[-1] * (1 + mpf(10) ** -40)])))
        turning = [[turn[::-1] for turn in system.pose.turning[0]], *system.pose.turning[1:]]
        return true(replace(system, pose=replace(system.pose, turning=turning)))

    monkeypatch.setattr(inertia, "DENSE", 0)
    monkeypatch.setattr(inertia, "_rows", rows)
    with pytest.raises(ConvergenceError, match="does not hold the accelerations"):
        reference(scene, "forward_dynamics", state(scene))


def test_a_loss_of_digits_is_met_by_more_of_them(monkeypatch: pytest.MonkeyPatch) -> None:
    """With no bits to spare the first precision is not enough; the next one gives the same answer."""
    scene = chain(KINDS["relative"])
    true = reference(scene, "forward_dynamics", state(scene))["a"]
    monkeypatch.setattr(inertia, "DENSE", 0)
    monkeypatch.setattr(inertia, "_LOST_BITS", -200)
    with mp.workdps(50):
        assert distance(reference(scene, "forward_dynamics", state(scene))["a"], true) < mpf(10) ** -48


def test_elimination_solves_random_sparse_systems_and_refuses_singular_ones() -> None:
    source = random.Random(5)
    size = 12
    with mp.workdps(40):
        rows = [{j: mpf(source.uniform(-1, 1)) for j in range(size) if abs(i - j) < 4 and source.random() < 0.8} for i in range(size)]
        for i, row in enumerate(rows):
            row.setdefault(size - 1 - i, mpf(1))
        x = [mpf(source.uniform(-1, 1)) for _ in range(size)]
        right = [sum((entry * x[j] for j, entry in row.items()), mpf(0)) for row in rows]
        assert distance(factored(rows).solve(right), x) < mpf(10) ** -30
        with pytest.raises(ConvergenceError, match="singular"):
            factored([{0: mpf(1), 1: mpf(2)}, {0: mpf(2), 1: mpf(4)}])


def operations(call: Callable[[], object]) -> int:
    """How many operations on mpf a call makes."""
    count = 0

    def seen(frame: FrameType, event: str, arg: object) -> None:
        nonlocal count
        if event == "call" and frame.f_code.co_name in ("python_mpf_mul", "mpf_add", "mpf_div", "mpf_sum"):
            count += 1

    sys.setprofile(seen)
    try:
        call()
    finally:
        sys.setprofile(None)
    return count


@pytest.mark.long
@kinds
def test_accelerations_and_forces_cost_operations_in_proportion_to_the_links(kind: dict[str, Any]) -> None:
    functions = ["forward_dynamics", "coriolis", "gravity_torque", "energy", "momentum", "positions"]
    functions += ["direction_dynamics"] if kind.get("space") else ["inverse_dynamics"]
    for function in functions:
        counts = []
        for links in (16, 32):
            scene = made(kind, [1.5] * links, [0.7] * links)
            counts.append(operations(partial(reference, scene, function, state(scene))))
        assert counts[0] > 100 and counts[1] < 2.1 * counts[0], (function, counts)


def test_matrices_cost_operations_in_proportion_to_their_entries() -> None:
    for function, inputs in (("mass_matrix", "q"), ("linearization", "s")):
        counts = []
        for links in (8, 16, 32):
            scene = Scene("chain", links, mass=1.5, length=0.7, damping=0.1)
            counts.append(operations(partial(reference, scene, function, {inputs: [1.0] * links})))
        assert counts[2] / counts[1] < 4.2 and counts[0] > 100, (function, counts)
