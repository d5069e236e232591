"""The emitted step: its order on smooth and on stiff motions, its error estimate, and the manifold it keeps to."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from phichain.reference import reference
from tests.stiff.systems import SCENES, spatial_start, system

Vector = NDArray[np.float64]
START = {
    "free_pair": ((np.array([0.5, 0.2]), np.array([0.3, 0.8])), {}),
    "spatial_free": (spatial_start(2, 0), {}),
    "spatial_stiff": (spatial_start(2, 2), {"p": {"mass": [1.0, 0.7]}, "u": np.zeros(2)}),
}


def after(name: str, span: float, steps: int, start: tuple[Vector, Vector], **more: Any) -> Vector:
    q, v = start
    for _ in range(steps):
        q, v, _, _ = step(name, span / steps, q, v, **more)
    return np.concatenate([q, v])


def step(name: str, h: float, q: Vector, v: Vector, **more: Any) -> tuple[Vector, ...]:
    given = dict(more)
    inputs = [given.pop("u")] if "u" in given else []
    return system(name).step_rosenbrock(h, q, v, *inputs, **given)


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "h"), [("free_pair", 0.01), ("spatial_free", 0.01), ("spatial_stiff", 1e-5)]
)
def test_the_local_error_is_of_order_six(name: str, h: float) -> None:
    """Against sixteen steps of a sixteenth; the estimate, the difference to a step of order 4, is of order five."""
    (q, v), more = START[name]
    gaps, estimates = [], []
    for size in (h, h / 2):
        q_next, v_next, q_error, v_error = step(name, size, q, v, **more)
        gaps.append(np.max(np.abs(np.concatenate([q_next, v_next]) - after(name, size, 16, (q, v), **more))))
        estimates.append(max(np.max(np.abs(q_error)), np.max(np.abs(v_error))))
    assert abs(np.log2(gaps[0] / gaps[1]) - 6) < 0.2
    assert 4.7 < np.log2(estimates[0] / estimates[1]) < 5.7


@pytest.mark.parametrize(("name", "span"), [("free_pair", 1.0), ("spatial_free", 0.5)])
def test_order_five_on_a_smooth_motion(name: str, span: float) -> None:
    """Global error, in the plane and in the chart of the sphere."""
    (q, v), _ = START[name]
    exact = system(name).propagate_stiff(q, v, 0.0, span, 1e-15)
    errors = [np.max(np.abs(after(name, span, n, (q, v)) - np.append(exact.q, exact.v))) for n in (96, 192)]
    assert abs(np.log2(errors[0] / errors[1]) - 5) < 0.1


def test_order_five_survives_stiffness() -> None:
    """On the slow motion of a chain with a joint of 1e13 N m/rad, after its transient: steps of 1e5 times its period.

    Stiffly accurate methods that satisfy the conditions of order for differential-algebraic equations lose nothing
    on the slow components (Hairer & Wanner, VI.4), the limit of a rigid joint.
    """
    pair = system("rigid_joint")
    start = pair.propagate_stiff([1.0, 0.0], [0.0, 0.0], 0.0, 0.2, 1e-14)
    exact = pair.propagate_stiff(start.q, start.v, 0.0, 1.0, 1e-14)
    errors = [
        np.max(np.abs(after("rigid_joint", 1.0, n, (start.q, start.v)) - np.append(exact.q, exact.v)))
        for n in (64, 128)
    ]
    assert abs(np.log2(errors[0] / errors[1]) - 5) < 0.1


def test_a_stiff_transient_is_gone_after_two_steps() -> None:
    """R(infinity) = 0: a deflection of 1e-3 rad, 1e10 N m, is damped to what the load keeps up."""
    q, v, _, _ = system("rigid_joint").step_rosenbrock(1e-2, [1.0, 1e-3], [0.0, 0.0])
    q, v, _, _ = system("rigid_joint").step_rosenbrock(1e-2, q, v)
    assert abs(q[1]) < 1e-8


@pytest.mark.parametrize("name", ["rigid_joint", "spatial_free", "overdamped"])
def test_it_is_the_dense_reference(name: str) -> None:
    """C against the dense step in 50 digits, at steps that damp and at steps that resolve."""
    scene = SCENES[name]
    q, v = spatial_start(2, 0) if not scene.is_planar else (np.array([1.0, 1e-9]), np.array([0.3, 0.0]))
    for h in (1e-2, 1e-6):
        found = system(name).step_rosenbrock(h, q, v)
        exact = reference(scene, "step_rosenbrock", {"h": h, "q": q.tolist(), "v": v.tolist()}, digits=25)
        for values, key in zip(found[:2], ("q_next", "v_next"), strict=True):
            expected = np.array([float(x) for x in exact[key]])
            # Of 16 starts like the strained one, whose rates pass thousands, half leave 2e-13.
            assert np.max(np.abs(values - expected)) < 1e-12 * max(1.0, np.max(np.abs(expected))), (h, key)


def test_links_keep_their_length() -> None:
    (q, v), _ = START["spatial_free"]
    for _ in range(200):
        q, v, _, _ = system("spatial_free").step_rosenbrock(0.02, q, v)
    unit, rate = q.reshape(-1, 3), v.reshape(-1, 3)
    assert np.max(np.abs(np.linalg.norm(unit, axis=1) - 1)) < 3e-16
    assert np.max(np.abs(np.sum(unit * rate, axis=1))) < 3e-15


def test_too_long_a_step_is_not_finite() -> None:
    """A link that turns by more than a right angle leaves the chart: the error estimate cannot be mistaken for a good one."""
    (q, v), _ = START["spatial_free"]
    _, _, q_error, v_error = system("spatial_free").step_rosenbrock(3.0, q, v)
    assert not (np.max(np.abs(np.append(q_error, v_error))) < 1e-2)
