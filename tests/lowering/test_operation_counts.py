"""How many operations forward dynamics takes: + - * / and square roots one each, sines and cosines one each."""

from __future__ import annotations

from typing import Any

import pytest

from phichain.ir import count_operations, total_operations
from phichain.lowering import lower_function
from phichain.lowering.series import series
from phichain.lowering.series.series import HIGHEST
from phichain.mechanics import derive
from phichain.scene import Scene


def paper_a(links: int, **more: Any) -> Scene:
    """Paper A's chain, m = l = 1/N, with torques at every joint."""
    part = 1 / links
    keys: dict[str, Any] = {"mass": part, "length": part, "com": part / 2, "actuated": "all"}
    return Scene("a", links, **(keys | more))


def unforced(links: int, **more: Any) -> Scene:
    """The same masses at the ends of their links, left alone."""
    return paper_a(links, **({"com": 1 / links, "actuated": "none"} | more))


def paper_b(links: int, **more: Any) -> Scene:
    """Paper B's chain on a cart."""
    return Scene("b", links, space="spatial", base="cart", mass=0.1, length=0.1, cart_mass=0.5, **more)


def forward(chain: Scene, code: str = "unrolled") -> Any:
    return lower_function(derive(chain), "forward_dynamics", code)


@pytest.mark.parametrize(("links", "most"), [(2, 61), (4, 213), (8, 554), (32, 2702)])
def test_paper_a_with_torques(links: int, most: int) -> None:
    assert total_operations(forward(paper_a(links))) <= most


@pytest.mark.parametrize("links", [2, 5, 16, 64])
def test_paper_b_takes_50_operations_a_link_and_no_trigonometry(links: int) -> None:
    counts = count_operations(forward(paper_b(links)))
    assert counts.total() <= 50 * links
    assert not counts.keys() & {"sin", "cos"}


@pytest.mark.parametrize("links", [2, 5, 16, 64])
def test_tip_masses_in_the_plane_take_34_operations_and_one_sine_cosine_pair(links: int) -> None:
    counts = count_operations(forward(unforced(links)))
    assert counts.total() <= 34 * links
    assert counts["sin"] == counts["cos"] == links


@pytest.mark.parametrize("make", [paper_a, unforced, paper_b])
def test_growth_is_linear(make: Any) -> None:
    """From 8 to 64 links the operations grow elevenfold at most: the links at both ends of a chain take fewer."""
    small, large = make(8), make(64)
    assert total_operations(forward(large)) <= 11 * total_operations(forward(small))
    assert total_operations(forward(large, "loops")) <= 11 * total_operations(forward(small, "loops"))


@pytest.mark.parametrize("between", [(8, 14), (16, 64)])
@pytest.mark.parametrize("make", [paper_a, unforced, paper_b])
def test_loops_do_not_grow(make: Any, between: tuple[int, int]) -> None:
    """The loops form is the same text for every length, on either side of that from which the two sides of a planar chain are lanes."""
    small, large = (str(forward(make(links), "loops")).count("\n") for links in between)
    assert small == large


def test_lanes_are_the_shorter_text() -> None:
    """452 lines of a Program for 14 links, 329 for 16: one formula serves both sides."""
    assert str(forward(paper_a(16), "loops")).count("\n") < 0.75 * str(forward(paper_a(14), "loops")).count("\n")


@pytest.mark.parametrize(("links", "most"), [(1, 34), (2, 72), (3, 122), (5, 214)])
def test_few_links_on_a_heavy_cart(links: int, most: int) -> None:
    """The forces on a cart above a sixteenth of the chain are added as they are; a light one takes eight operations more."""
    assert total_operations(forward(paper_b(links))) <= most
    light = Scene("light", links, space="spatial", base="cart", mass=0.1, length=0.1, cart_mass=0.001)
    assert total_operations(forward(light)) >= total_operations(forward(paper_b(links))) + 6


def test_two_links_divide_once() -> None:
    """The tip's first pivot is a number; what is solved for is the tension of the first link."""
    assert count_operations(forward(paper_b(2)))["div"] == 1


@pytest.mark.parametrize(("ratio", "most"), [(0.5, 205), (0.1, 575)])
def test_spatial_masses_before_the_ends(ratio: float, most: int) -> None:
    """By mobilities, and near the joints free of subtractions."""
    counts = count_operations(forward(paper_b(16, com=0.1 * ratio)))
    assert counts.total() <= most * 16
    assert not counts.keys() & {"sin", "cos"}


def test_what_a_scene_lacks_costs_nothing() -> None:
    """Torques, springs, dampers, the cart and unequal numbers are paid for by those who have them."""
    bare = total_operations(forward(unforced(4)))
    dearer = [
        unforced(4, actuated="all"), unforced(4, stiffness=1.0), unforced(4, damping=1.0), paper_a(4, actuated="none"),
        unforced(4, base="cart", cart_mass=1.0), unforced(4, mass=[1.0, 2.0, 3.0, 4.0]), unforced(4, mass="runtime"),
    ]  # fmt: skip
    for chain in dearer:
        assert total_operations(forward(chain)) > bare
    assert count_operations(forward(unforced(1))) == {"sin": 1, "mul": 1}


def one_link(**more: Any) -> Any:
    return series(derive(Scene("one", 1, mass=0.7, length=0.5, **more)))


@pytest.mark.parametrize(("more", "most"), [({}, 713), ({"actuated": "all"}, 772), ({"real": "float"}, 285)])
def test_all_orders_of_one_link_take_two_thirds_of_what_one_by_one_takes(more: dict[str, Any], most: int) -> None:
    made, highest = one_link(**more), HIGHEST[more.get("real", "double")]
    products = sum(made.lanes * (2 * n + 1) for n in range(2, highest + 1))
    one_by_one = products + (highest - 1) * total_operations(made.order)
    assert total_operations(made.outright) <= min(most, 0.71 * one_by_one)


@pytest.mark.parametrize("more", [{"stiffness": 1.0}, {"damping": 0.1}, {"code": "loops"}, {"friction": 0.1, "friction_speed": 0.2}])
def test_orders_come_one_by_one_where_more_than_weight_and_torque_acts(more: dict[str, Any]) -> None:
    assert one_link(**more).outright is None
