"""The maps between angles against plain matrices."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from phichain.mechanics import coordinates

KINDS = ("absolute", "relative", "adjacent")
vectors = st.lists(st.floats(-10, 10), min_size=1, max_size=7).map(np.array)
kinds = pytest.mark.parametrize("angles", KINDS)


def test_the_three_readings_of_paper_a() -> None:
    assert coordinates.absolute_angles("relative", [1, 10, 100, 1000]) == (1, 11, 111, 1111)
    assert coordinates.absolute_angles("adjacent", [1, 10, 100, 1000]) == (1, 11, 110, 1100)
    assert coordinates.absolute_angles("absolute", [1, 10, 100, 1000]) == (1, 10, 100, 1000)


@kinds
@given(theta=vectors)
def test_every_map_is_its_matrix(angles: str, theta: np.ndarray) -> None:
    size = len(theta)
    S = np.array(coordinates.angle_map(angles, size))
    differences = np.eye(size) - np.eye(size, k=-1)
    near = {"rtol": 1e-12, "atol": 1e-12}
    np.testing.assert_allclose(coordinates.absolute_angles(angles, theta), S @ theta, **near)
    np.testing.assert_allclose(coordinates.scene_angles(angles, S @ theta), theta, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(coordinates.joint_angles(angles, theta), differences @ S @ theta, **near)
    np.testing.assert_allclose(coordinates.pull_back(angles, theta), S.T @ theta, **near)
    np.testing.assert_allclose(coordinates.couples(theta), differences.T @ theta, **near)
    np.testing.assert_allclose(coordinates.joint_forces(angles, theta), (differences @ S).T @ theta, **near)


@kinds
def test_matrices_pull_back_on_both_sides(angles: str) -> None:
    matrix = np.random.default_rng(1).normal(size=(5, 5))
    S = np.array(coordinates.angle_map(angles, 5))
    np.testing.assert_allclose(coordinates.pull_back_matrix(angles, matrix), S.T @ matrix @ S, rtol=1e-13)
