"""The System record: absent functions, packing, right-hand side and its Jacobian."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

from phichain.errors import ArrayError, UnsupportedError
from phichain.system import (
    AbsentFunctionError,
    System,
    angular_velocities,
    hat,
    pack,
    rhs,
    rhs_jacobian,
    unit_vectors,
    unpack,
    velocity,
)
from tests.handmade import paper_b, planar, spatial, uniform_planar


def twice(q: np.ndarray, v: np.ndarray, p: dict[str, float] | None = None) -> np.ndarray:
    """Dynamics at module level, so that a System of it can be pickled."""
    return -q * (1.0 if p is None else p["rate"])


PLAIN = System(
    "plain", "planar", "fixed", 1, 1, 1, 0, functions={"forward_dynamics": twice}, params={"rate": 2.0}
)


def test_an_absent_function_is_a_typed_error_that_hasattr_understands() -> None:
    with pytest.raises(
        AbsentFunctionError, match='add "energy" to .functions. want.*forward_dynamics'
    ) as caught:
        PLAIN.energy  # noqa: B018
    assert isinstance(caught.value, UnsupportedError) and caught.value.available == ("forward_dynamics",)
    assert not hasattr(PLAIN, "energy") and hasattr(PLAIN, "forward_dynamics") and not PLAIN.has("energy")


def test_a_system_is_frozen_copied_and_pickled() -> None:
    with pytest.raises(AttributeError):
        PLAIN.name = "other"  # type: ignore[misc]
    with pytest.raises(TypeError):
        PLAIN.functions["energy"] = twice  # type: ignore[index]
    for twin in (pickle.loads(pickle.dumps(PLAIN)), copy.copy(PLAIN), copy.deepcopy(PLAIN)):
        assert twin == PLAIN and twin.forward_dynamics(np.ones(1), np.ones(1), p={"rate": 3.0}) == -3
    assert "plain: planar chain of 1 link" in str(PLAIN)


def test_sizes_follow_from_space_and_base() -> None:
    assert [
        s.cart_size for s in (PLAIN, planar([1.0], [1.0], cart_mass=1.0), spatial([1.0], [1.0]), paper_b())
    ] == [0, 1, 0, 2]
    assert paper_b().nx == 34 and paper_b().has_cart and not paper_b().is_planar


def test_packing_and_its_parts() -> None:
    system, rng = paper_b(), np.random.default_rng(0)
    q, v = rng.normal(size=(3, 17)), rng.normal(size=(3, 17))
    x = pack(q, v)
    assert all(np.array_equal(a, b) for a, b in zip(unpack(system, x), (q, v), strict=True))
    assert unit_vectors(system, q).shape == angular_velocities(system, v).shape == (3, 5, 3)
    assert np.array_equal(unit_vectors(system, q)[1, 2], q[1, 8:11])
    for bad in (np.zeros(33), 1.0):
        with pytest.raises(ArrayError, match="nq . nv = 34"):
            unpack(system, bad)


def test_the_right_hand_side_takes_a_batch_and_parameters() -> None:
    x = np.array([[1.0, 2.0], [3.0, 4.0]])
    assert rhs(PLAIN)(0.0, x).tolist() == [[2, -2], [4, -6]]
    assert rhs(PLAIN)(0.0, x[0], p={"rate": 5.0}).tolist() == [2, -5]
    system, rng = paper_b(), np.random.default_rng(1)
    states, f = rng.normal(size=(4, 34)), rhs(system)
    rows = f(0.0, states, [0.1, 0.2])
    assert np.allclose(rows, [f(0.0, x, [0.1, 0.2]) for x in states], rtol=1e-14)
    assert np.array_equal(
        rows[:, 17:], system.forward_dynamics(states[:, :17], states[:, 17:], np.full((4, 2), [0.1, 0.2]))
    )
    moving = velocity(system, states[:, :17], states[:, 17:])
    for k in range(5):
        at = slice(2 + 3 * k, 5 + 3 * k)
        assert np.allclose(moving[:, at], np.cross(states[:, 17:][:, at], states[:, :17][:, at]))
    with pytest.raises(ArrayError, match="nu = 2"):
        f(0.0, states, [0.1])
    with pytest.raises(AbsentFunctionError):
        rhs(uniform_planar(1, leave_out=["forward_dynamics"]))


@pytest.mark.parametrize("make", [lambda: uniform_planar(2, cart_mass=0.4, actuated="all"), paper_b])
def test_the_jacobian_is_the_slope_of_the_right_hand_side(make) -> None:
    system, rng = make(), np.random.default_rng(2)
    x, u = rng.normal(size=system.nx), rng.normal(size=system.nu)
    f, width = rhs(system), 1e-6
    slopes = [(f(0.0, x + width * e, u) - f(0.0, x - width * e, u)) / (2 * width) for e in np.eye(system.nx)]
    exact = rhs_jacobian(system)(0.0, x, u)
    assert np.max(np.abs(np.transpose(slopes) - exact)) < 1e-7 * np.max(np.abs(exact))


def test_hat_is_the_cross_product() -> None:
    a, b = np.array([1.0, -2.0, 3.0]), np.array([0.5, 4.0, -1.0])
    assert np.array_equal(hat(a) @ b, np.cross(a, b))


@pytest.mark.parametrize("call", ["simulate(scene, ([0.1], [0.0]), 1.0)", "trace(scene)", "lqr(scene)"])
def test_a_scene_that_nobody_built_is_told_so_in_one_sentence(call: str) -> None:
    from phichain import Scene, lqr, simulate, trace

    scene = Scene("plain", 1, mass=1.0, length=1.0)
    with pytest.raises(ArrayError, match=r"is a Scene, of which nothing is compiled yet .*; hand over what build\(scene\) returns"):
        eval(call, {"scene": scene, "simulate": simulate, "trace": trace, "lqr": lqr})
    with pytest.raises(ArrayError, match="system: is no System"):
        simulate("planar4", ([0.1], [0.0]), 1.0)  # type: ignore[arg-type]
