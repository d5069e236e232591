"""Spatial Jacobians from one factorisation: their operations, their digits, both shapes, both functions."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from mpmath import mpf

from phichain.errors import ProofError
from phichain.ir import evaluate, total_operations
from phichain.ir.nodes import Program
from phichain.lowering import lower, lower_function
from phichain.lowering.spatial.jacobian import columns
from phichain.mechanics import derive
from phichain.proof import prove
from phichain.reference import reference
from phichain.reference.derived import tangents
from phichain.scene import Scene
from phichain.transform.blocks import Block
from phichain.transform.tangent import jacobian
from tests.lowering.hard_chains import SPREADS
from tests.lowering.test_planar_jacobian import _flipped, _ops

CART = {"base": "cart", "cart_mass": 1.3, "actuated": "cart"}
FREE = {"place": 0.6}


def chain(links: int, place: float | None = None, **more: Any) -> Scene:
    """No two links alike."""
    some = np.random.default_rng(links)
    keys: dict[str, Any] = {
        "mass": np.exp(some.uniform(-1, 1, links)).tolist(),
        "length": some.uniform(0.3, 1.4, links).tolist(),
    }
    keys |= {"want": ["state_jacobian", "dynamics_and_jacobian"], "space": "spatial"} | more
    if place is not None:
        keys["com"] = [place * entry for entry in keys["length"]]
    return Scene("some", links, **keys)


def arguments(scene: Scene, seed: int = 1) -> dict[str, Any]:
    some = np.random.default_rng(seed)
    q = some.standard_normal((scene.links, 3))
    q /= np.linalg.norm(q, axis=1)[:, None]
    turning = np.cross(q, some.standard_normal(q.shape)).ravel()
    cart = some.standard_normal((2, 2 * int(scene.has_cart)))
    found = {
        "q": np.append(cart[0], q),
        "v": np.append(cart[1], turning),
        "u": some.standard_normal(scene.nu),
    }
    return {name: values for name, values in found.items() if values.size}


def differentiated(scene: Scene) -> Program:
    """The forward dynamics in loops, differentiated by the transform."""
    blocks = [Block("a", name, f"dad{name}") for name in ("q", "v", "u")[: 2 + (scene.nu > 0)]]
    return jacobian(lower_function(derive(scene), "forward_dynamics", "loops"), "state_jacobian", "", blocks)


def errors(scene: Scene, seed: int, *programs: Program) -> list[float]:
    """Of the rows of derivatives along the manifold, in units of their largest entry."""
    given = arguments(scene, seed)
    exact = reference(scene, "state_jacobian", given)
    along = tangents(scene, *([mpf(float(entry)) for entry in given[name]] for name in "qv"))
    ways = np.array([[float(entry) for entry in (*dq, *dv)] for dq, dv in along])
    true, found = np.array(exact["tangent"], dtype=float), []
    for program in programs:
        out = evaluate(program, given)
        both = np.hstack([out[name].reshape(scene.nv, -1) for name in ("dadq", "dadv")])
        worst = np.abs(ways @ both.T - true).max() / np.abs(true).max()
        if scene.nu:
            pushed = np.array(exact["dadu"], dtype=float)
            worst = max(
                worst, np.abs(out["dadu"].reshape(pushed.shape) - pushed).max() / np.abs(pushed).max()
            )
        found.append(float(worst))
    return found


@pytest.mark.parametrize(
    ("more", "entry", "link"), [({}, 23, 680), (CART, 23, 740), (FREE, 175, 1000), (FREE | CART, 175, 1200)]
)
@pytest.mark.parametrize("links", [8, 12])
def test_operations_grow_with_the_square_of_the_links(
    links: int, more: dict[str, Any], entry: int, link: int
) -> None:
    """Per pair of links 2 x 2 blocks of 3 x 3; the differentiated sweeps take 350 and 1570 where this has 23 and 175."""
    found = lower_function(derive(chain(links, **more)), "state_jacobian", "loops")
    assert total_operations(found) <= entry * links**2 + link * links


@pytest.mark.parametrize("more", [{}, CART, FREE, FREE | CART])
@pytest.mark.parametrize("links", [2, 5])
def test_auto_takes_the_form_of_fewer_operations(links: int, more: dict[str, Any]) -> None:
    scene = chain(links, **more)
    assert total_operations(lower(derive(scene)).wanted["state_jacobian"]) <= total_operations(
        differentiated(scene)
    )


@pytest.mark.parametrize("base", [{}, CART])
@pytest.mark.parametrize("spread", ["heavy tip", "heavy in turn", "heavier outwards"])
def test_masses_that_spread_keep_the_differentiated_tensions(spread: str, base: dict[str, Any]) -> None:
    """Eight and sixteen decades apart, where the written form leaves 1e-9."""
    mass, length = (values.tolist() for values in SPREADS[spread](6))
    scene = chain(6, mass=mass, length=length, **base)
    found = lower_function(derive(scene), "state_jacobian", "loops")
    assert total_operations(found) == total_operations(differentiated(scene))


@pytest.mark.parametrize("base", [{}, CART])
@pytest.mark.parametrize("mass", [[1.0, 2.0, 0.5, 15.0], [1.0] * 4])
def test_the_heaviest_loads_leave_fifteen_digits(mass: list[float], base: dict[str, Any]) -> None:
    """On hanging chains and bent ones."""
    scene = chain(4, mass=mass, length=[1.0, 0.3, 2.0, 0.7], **base)
    assert max(errors(scene, 3, lower_function(derive(scene), "state_jacobian", "loops"))) < 8e-15


@pytest.mark.parametrize("base", [{}, CART])
@pytest.mark.parametrize("place", [0.3, 0.9, 1 - 1e-8])
def test_masses_on_the_links_cost_no_digit(place: float, base: dict[str, Any]) -> None:
    scene = chain(4, place, mass=[1.0, 30.0, 0.05, 2.0], **base)
    ours, before = errors(
        scene, 2, lower_function(derive(scene), "state_jacobian", "loops"), differentiated(scene)
    )
    assert ours <= max(8 * before, 4e-15)


@pytest.mark.parametrize("more", [{}, CART, FREE, FREE | CART])
def test_two_rows_of_memory_serve_long_chains(more: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    for links in (6, 7):
        scene = chain(links, **more)
        given = arguments(scene)
        kept = evaluate(lower_function(derive(scene), "state_jacobian", "loops"), given)
        monkeypatch.setattr(columns, "LONGEST_KEPT", 3)
        program = lower_function(derive(scene), "state_jacobian", "loops")
        monkeypatch.undo()
        assert any(array.name.startswith("couple_state_odd") for array in program.work)
        for name, values in evaluate(program, given).items():
            assert np.abs(values - kept[name]).max() < 1e-13 * np.abs(values).max()


@pytest.mark.parametrize("more", [CART, FREE])
def test_dynamics_and_jacobian_are_both(more: dict[str, Any]) -> None:
    """A uniform chain in units of its own among them."""
    alike = {"mass": [2.0] * 6, "length": [0.7] * 6} if "base" in more else {}
    scene = chain(6, **(more | alike))
    given, names = arguments(scene), ("dynamics_and_jacobian", "state_jacobian", "forward_dynamics")
    both, slopes, a = (evaluate(lower_function(derive(scene), name, "loops"), given) for name in names)
    assert np.allclose(both["a"], a["a"], rtol=1e-13, atol=1e-13)
    assert all(np.array_equal(both[name], slopes[name]) for name in slopes)
    assert errors(scene, 1, lower_function(derive(scene), "state_jacobian", "loops"))[0] < 3e-15


@pytest.mark.parametrize(
    "more", [{"mass": "runtime", "length": "runtime"} | CART | {"cart_mass": "runtime"}, FREE]
)
def test_a_wrong_sign_anywhere_is_refused(more: dict[str, Any]) -> None:
    """Every addition turned into a subtraction in turn (some of many)."""
    scene = chain(3, **(more | {"code": "loops", "want": ["state_jacobian"]}))
    model = derive(scene)
    lowered = lower(model)
    prove(model, lowered)
    program = lowered.wanted["state_jacobian"]
    places = [i for i, op in enumerate(_ops(program.body)) if op.kind == "add"]
    for place in places[:: max(1, len(places) // 12)]:
        wrong = replace(program, body=_flipped(program.body, [place]))
        with pytest.raises(ProofError):
            prove(model, replace(lowered, wanted={"state_jacobian": wrong}))
