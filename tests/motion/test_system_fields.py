"""A System says itself which angles, joints, numbers and drive it has; nobody reads them out of its scene."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import phichain
from phichain import Scene, build
from phichain.errors import ArrayError
from phichain.system import Drive, Joints, Numbers, System

ROOT = Path(phichain.__file__).parent


def chain(**more: object) -> System:
    return System("s", "planar", "cart", 2, 3, 3, 2, **more)  # type: ignore[arg-type]


def test_nobody_reads_a_systems_scene() -> None:
    """`system.scene` is for the record: what numerics need has a field. Trials compile the chain anew, above the pipeline."""
    found = [
        f"{path.relative_to(ROOT)}:{number}"
        for path in sorted(ROOT.rglob("*.py"))
        if path.relative_to(ROOT).parts[0] != "trials"
        for number, line in enumerate(path.read_text().splitlines(), 1)
        if "system.scene" in line and "import" not in line
    ]
    assert found == []


def test_the_fields_of_a_built_scene() -> None:
    scene = Scene(
        "fields", 3, base="cart", mass=[0.3, 0.2, 0.1], length="runtime", com="runtime", cart_mass=0.7, angles="relative",
        damping=0.1, actuated=[1, 3], want=["forward_dynamics"],
    )  # fmt: skip
    system = build(scene)
    assert system.angles == "relative"
    assert system.joints == Joints(damping=(0.1,) * 3) and not system.joints.is_free
    assert system.numbers == Numbers((0.3, 0.2, 0.1), "runtime", "runtime", 0.7, 9.81)
    # A force on the cart, torques at the first and third angle.
    assert system.drive == Drive((0, 1, 3))
    lengths = np.array([0.4, 0.3, 0.2])
    # What the drive says is what the compiled dynamics do: B u = M (a(u) - a(0)), B with columns of the identity.
    p = {"length": lengths, "com": lengths / 2}
    q, v = np.array([0.1, 0.4, -0.3, 0.8]), np.array([0.2, -0.5, 0.3, 0.1])
    free = system.forward_dynamics(q, v, np.zeros(3), p=p)
    inputs = np.array([system.forward_dynamics(q, v, row, p=p) - free for row in np.eye(3)]).T
    every = build(replaced(scene))
    by_all = np.array([every.forward_dynamics(q, v, row, p=p) - free for row in np.eye(4)]).T
    assert np.allclose(inputs, by_all @ system.drive.forces(np.eye(3), 4).T, rtol=0, atol=1e-13 * np.abs(by_all).max())
    assert system.number("length", p) is not None and system.number("length", p)[1] == 0.3
    with pytest.raises(ArrayError, match="p.length: system 'fields' holds no value"):
        system.number("length")


def replaced(scene: Scene) -> Scene:
    tables = scene.to_dict()
    tables["joints"]["actuated"] = "all"
    return phichain.scene.scene_from_dict(tables | {"name": "fields_all"})


@pytest.mark.parametrize("base", ["fixed", "cart"])
def test_a_spatial_chain_has_no_angles_and_its_cart_two_forces(base: str) -> None:
    more = {"cart_mass": 0.5, "actuated": "cart"} if base == "cart" else {}
    system = build(Scene(f"space_{base}", 1, "spatial", base, mass=0.2, length=0.3, want=["energy"], **more))
    assert system.angles is None and system.drive == Drive((0, 1) if base == "cart" else ())
    assert system.joints.is_free and system.numbers.com is None


def test_a_cart_that_nobody_pushes_is_no_drive() -> None:
    scene = Scene("free_cart", 1, base="cart", mass=0.2, length=0.3, cart_mass=0.5, actuated="none", want=["energy"])
    assert build(scene).drive == Drive(())


def test_what_is_not_said_is_the_usual() -> None:
    system = chain()
    assert system.angles == "relative" and system.joints == Joints() and system.drive == Drive((0, 1))
    assert system.number("com", default=np.ones(2)).tolist() == [1, 1]


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: chain(angles="polar"), "angles: is no kind of angles"),
        (lambda: System("s", "spatial", "fixed", 1, 3, 3, 0, angles="relative"), "belongs to a planar chain"),
        (lambda: chain(drive=Drive((0,))), "must hold 2 different numbers below 3"),
        (lambda: chain(drive=Drive((0, 0))), "must hold 2 different numbers below 3"),
        (lambda: chain(drive=Drive((0, 3))), "must hold 2 different numbers below 3"),
        (lambda: Numbers(mass=[1.0, "heavy"]), "mass: is no number"),
        (lambda: Numbers(length=np.ones((2, 2))), "length: is no number"),
        (lambda: Joints(damping=np.nan), "damping: is no number"),
        (lambda: chain().number("stiffness"), "p.stiffness"),
        (lambda: chain().number("inertia"), "p.inertia"),
    ],
)
def test_what_does_not_fit_is_refused(make, words) -> None:
    with pytest.raises(ArrayError, match=words):
        make()


def test_a_system_cannot_be_written_to_and_survives_pickling() -> None:
    masses, table = np.array([1.0, 2.0]), {"chain": {"mass": [1.0, 2.0]}}
    system = chain(numbers=Numbers(mass=masses, length="runtime"), params={"length": masses}, scene=table)
    masses[0] = 9.0
    table["chain"]["mass"][0] = 9.0
    for made in (system, pickle.loads(pickle.dumps(system)), replace(system, name="t")):
        assert made.numbers.mass == (1.0, 2.0) and made.params["length"].tolist() == [1.0, 2.0]
        assert made.scene["chain"]["mass"] == (1.0, 2.0)
        with pytest.raises(TypeError):
            made.scene["chain"]["mass"] = 0
        with pytest.raises(ValueError, match="read-only"):
            made.params["length"][0] = 0
        assert made.number("length").tolist() == [1.0, 2.0]
