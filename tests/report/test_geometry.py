"""Joints drawn where they are: against closed forms, lengths, and the three kinds of angles against each other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from phichain.errors import ArrayError
from phichain.report.geometry import joints, link_lengths, tilt
from phichain.system import Numbers, System

LENGTHS = [0.5, 0.3, 0.2]


def planar(angles: str = "relative", base: str = "fixed") -> System:
    size = 3 + (base == "cart")
    return System("drawn", "planar", base, 3, size, size, 0, angles=angles, numbers=Numbers(length=LENGTHS))


def spatial(base: str = "cart") -> System:
    size = 9 + 2 * (base == "cart")
    return System("drawn", "spatial", base, 3, size, size, 0, numbers=Numbers(length=LENGTHS))


def test_a_hanging_chain_hangs_along_gravity() -> None:
    points = joints(planar(), np.zeros(3))
    np.testing.assert_allclose(points, [[0, 0], [0, 0.5], [0, 0.8], [0, 1.0]])


def test_relative_angles_add_up_and_positive_swings_towards_e1() -> None:
    points = joints(planar(), [np.pi / 2, -np.pi / 2, np.pi])
    np.testing.assert_allclose(points, [[0, 0], [0.5, 0], [0.5, 0.3], [0.5, 0.1]], atol=1e-15)


def test_a_cart_carries_the_chain_along() -> None:
    still = joints(planar(), [0.1, 0.2, 0.3])
    moved = joints(planar(base="cart"), [2.0, 0.1, 0.2, 0.3])
    np.testing.assert_allclose(moved - still, np.broadcast_to([2.0, 0.0], (4, 2)))


@given(st.lists(st.floats(-20, 20), min_size=3, max_size=3))
@settings(max_examples=30, deadline=None)
def test_the_three_kinds_of_angles_draw_one_chain(phi: list[float]) -> None:
    relative = np.diff(phi, prepend=0.0)
    adjacent = np.array([phi[0], phi[1] - phi[0], phi[2] - phi[1] + phi[0]])
    expected = joints(planar("absolute"), phi)
    np.testing.assert_allclose(joints(planar("relative"), relative), expected, atol=1e-12)
    np.testing.assert_allclose(joints(planar("adjacent"), adjacent), expected, atol=1e-12)
    np.testing.assert_allclose(tilt(planar("adjacent"), adjacent), phi, atol=1e-12)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_every_link_keeps_its_length_over_a_whole_batch(seed: int) -> None:
    draw = np.random.default_rng(seed)
    unit = draw.normal(size=(5, 3, 3))
    unit /= np.linalg.norm(unit, axis=-1, keepdims=True)
    q = np.concatenate([draw.normal(size=(5, 2)), unit.reshape(5, 9)], axis=1)
    points = joints(spatial(), q)
    np.testing.assert_allclose(np.linalg.norm(np.diff(points, axis=1), axis=-1), np.tile(LENGTHS, (5, 1)))
    np.testing.assert_allclose(points[:, 0, :2], q[:, :2])
    np.testing.assert_allclose(np.cos(tilt(spatial(), q)), unit[..., 2], atol=1e-15)


def test_tilt_is_exact_near_hanging_and_standing() -> None:
    small = 1e-9
    q = np.array([np.sin(small), 0, np.cos(small), 0, -np.sin(small), -np.cos(small), 0, 0, 1.0])
    np.testing.assert_allclose(tilt(spatial("fixed"), q), [small, np.pi - small, 0.0], rtol=1e-15)


def test_lengths_may_come_from_the_runtime_parameters() -> None:
    runtime = replace(planar(), numbers=Numbers(length="runtime"), params={"length": [1.0, 2.0, 3.0]})
    np.testing.assert_array_equal(link_lengths(runtime), [1.0, 2.0, 3.0])
    with pytest.raises(ArrayError, match="holds no value of it"):
        link_lengths(replace(runtime, params=None))
