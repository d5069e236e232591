"""Starting points: the leaning chain leans in every kind of coordinates, and typed numbers are read or refused."""

from __future__ import annotations

import numpy as np
import pytest

from phichain.errors import ArrayError
from phichain.report.geometry import directions
from phichain.system import System
from phichain.system.starts import leaning, numbers, parameters


def system(space: str, base: str, angles: str = "relative", links: int = 5) -> System:
    cart = {"fixed": 0, "cart": 1 if space == "planar" else 2}[base]
    size = cart + links * (1 if space == "planar" else 3)
    return System("s", space, base, links, size, size, 0, angles=angles if space == "planar" else None)


@pytest.mark.parametrize("base", ["fixed", "cart"])
@pytest.mark.parametrize("angles", ["relative", "absolute", "adjacent"])
def test_every_planar_link_leans_by_the_same_angle(base: str, angles: str) -> None:
    chain = system("planar", base, angles)
    q, v = leaning(chain, 0.3)
    np.testing.assert_allclose(directions(chain, q), np.tile([np.sin(0.3), np.cos(0.3)], (5, 1)), atol=1e-15)
    assert q.shape == v.shape == (chain.nq,) and not v.any()


@pytest.mark.parametrize("base", ["fixed", "cart"])
def test_every_spatial_link_leans_by_the_same_angle(base: str) -> None:
    chain = system("spatial", base)
    q, v = leaning(chain, -1.0)
    np.testing.assert_allclose(directions(chain, q), np.tile([np.sin(-1.0), 0, np.cos(-1.0)], (5, 1)))
    assert q.shape == v.shape == (chain.nq,) and not v.any()


def test_numbers_are_read_with_commas_or_spaces() -> None:
    assert numbers(None, "q") is None
    read = numbers("1, -2e-3 4", "q")
    assert read is not None and read.tolist() == [1.0, -2e-3, 4.0]


def test_parameters_are_scalars_or_lists_by_name() -> None:
    assert parameters([]) is None
    read = parameters(["mass=1,2", " gravity = 9.81"])
    assert read is not None and read["gravity"] == 9.81
    np.testing.assert_array_equal(read["mass"], [1.0, 2.0])


@pytest.mark.parametrize("setting", ["mass", "mass=", "mass=a", "=1,b"])
def test_a_setting_that_is_none_is_refused(setting: str) -> None:
    with pytest.raises(ArrayError):
        parameters([setting])
