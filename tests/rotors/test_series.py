"""Taylor recurrences of chains with rotors keep their digits order by order, and know how fast such a chain swings."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp

from phichain.lowering.rates import fastest_rate
from phichain.lowering.series import series
from phichain.lowering.series.run import expand
from phichain.mechanics import derive
from phichain.scene import Scene
from tests.handmade import planar
from tests.lowering.taylor_oracle import DOUBLES, EXACT, gap
from tests.rotors.test_accuracy import CARTS, PLACES, random_chain

ORDERS = 6


@pytest.mark.parametrize("cart", CARTS)
@pytest.mark.parametrize("place", PLACES)
def test_every_order_keeps_its_digits(place: str, cart: str) -> None:
    """In doubles against 60 digits of the same, proven recurrences; gear ratios over sixteen decades."""
    for seed in range(4):
        chain, rng = random_chain(seed, place, cart), np.random.default_rng(seed)
        made = series(derive(chain))
        q, v, u = (list(rng.normal(size=size)) for size in (chain.nq, chain.nv, chain.nu))
        found = expand(made, DOUBLES, ORDERS, q=q, v=v, u=u)
        with mp.workdps(60):
            true = expand(made, EXACT, ORDERS, **{name: [mp.mpf(x) for x in row] for name, row in (("q", q), ("v", v), ("u", u))})
        size = chain.nq
        for one, other in zip(found.state, true.state, strict=True):
            assert gap([one[size:]], [other[size:]]) < 5e-13


@pytest.mark.parametrize("base", [{}, {"cart_mass": 0.4}], ids=["fixed", "cart"])
@pytest.mark.parametrize("gear", [1e-6, 1.0, 1e6])
def test_the_fastest_mode(gear: float, base: dict[str, float]) -> None:
    """To three digits that of the dense linear equations; their slowest are lost in doubles, not the fastest."""
    numbers = {"mass": [1.0, 0.4, 0.7], "length": [0.6, 0.5, 0.9], "com": [0.3, 0.5, 0.2], "stiffness": [1.0, 2.0, 3.0]}
    armature = [0.3 * gear, 0.0, 0.1 * gear]
    M, G = planar(**numbers, armature=armature, **base).linearization(np.ones(3))[:2]
    fastest = np.sqrt(np.max(np.linalg.eigvals(np.linalg.solve(M, G)).real))
    keys = {"base": "cart", **base} if base else {}
    rate = fastest_rate(Scene("geared", 3, **numbers, armature=armature, **keys))
    assert rate is not None
    assert float(rate) == pytest.approx(fastest, rel=6e-3)
