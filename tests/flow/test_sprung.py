"""Springs a million times stiffer than weight: what they do is small beside the chain's angles, and fast."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np
import pytest

from phichain.scene import Scene, scene_from_dict
from tests.flow.batch.batches import flow
from tests.flow.flows import compiled

BEND = 2.0**-20
"""How far springs are bent at the start, rad."""


@dataclass(frozen=True)
class Case:
    """A motion from rest and where it ends.

    Attributes:
        chain: the scene.
        q: where it starts.
        t: how long it moves, s.
        end: q and v there, in quadruple precision from the dense Lagrangian by extrapolation, or for one link by Taylor series in 34
            digits: to 25 digits and more whatever the order and steps.
        fastest: the fastest rate on the way, 1/s.
    """

    chain: Scene
    q: tuple[float, ...]
    t: float
    end: tuple[str, ...]
    fastest: float

    def off(self, q: Any, v: Any, lost: Any) -> float:
        """The largest error of rates over the fastest one and of the configuration, digits behind the last ones included."""
        with mpmath.workdps(34):
            found = [mpmath.mpf(float(a)) + mpmath.mpf(float(b)) for a, b in zip((*q, *v), lost[1:], strict=True)]
            apart = [abs(a - mpmath.mpf(b)) for a, b in zip(found, self.end, strict=True)]
        return float(max(*apart[: len(q)], max(apart[len(q) :]) / self.fastest))


def sprung(name: str, links: int, stiffness: list[float], space: str = "planar", joints: Mapping[str, Any] | None = None, **chain: Any) -> Scene:
    """A chain of links of 1 m and 1 kg with springs at its joints."""
    table = {"links": links, "space": space, "mass": 1.0, "length": 1.0, **chain}
    return scene_from_dict({"name": name, "chain": table, "joints": {"stiffness": stiffness, **(joints or {})}})


CASES = {
    "outer joint": Case(
        sprung("outer", 2, [0.0, 1e13]), (1.0, BEND), 2.0**-14,
        ("1.000000515600894717049107822367721", "-3.583916556071725975024852739589700e-07",
         "-2.499981784009935720168294337497796", "6.249198707549844243270300110171855"), 4.046376804985772,
    ),
    "beside a rest": Case(
        sprung("beside", 1, [1e13], joints={"rest_angle": [1.0]}), (1.0 + BEND,), 2.0**-14,
        ("0.9999998125551997300103150238455508537", "2.956959642223886217538431641528532"), 3.02,
    ),
    # Without weight the way a whole chain points to is nothing: as from (BEND, BEND / 2) with springs at rest in line.
    "both joints beside a rest": Case(
        sprung("both", 2, [1e13, 1e13], joints={"rest_angle": [1.0, 0.0]}, gravity=0.0), (1.0 + BEND, BEND / 2), 2.0**-14,
        ("0.9999998250067769282040109074561368805", "-2.910456917911027368322453983316291e-08",
         "1.457189170685365116773873203103192", "0.07403034090773835758079427739105214"), 2.1218305122338337,
    ),
    "in space": Case(
        sprung("inspace", 2, [0.0, 1e13], "spatial"),
        (0.6, 0.0, 0.8, float.fromhex("0x1.33333333328a5p-1"), float.fromhex("0x1.0c6f7a0b5e454p-20"), float.fromhex("0x1.9999999998b87p-1")),
        2.0**-16,
        ("0.5999999996710606176473105430691321", "2.120976005782785102892786845388253e-07", "0.8000000002466764207887536946597011",
         "0.5999999996709845805696365733036690", "6.818535985840985105685226405815155767e-07", "0.8000000002464709867609594084737889",
         "-1.997539994670166821294659037984909", "-5.418182201094144580419750388520804e-05", "1.498154994733703554076215078989579",
         "2.996309992094775636487205462525459", "-5.344711559176394504851059740930870e-05", "-2.247232492100890593987869373151107"),
        3.3941125435285304,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_a_fast_small_motion_keeps_its_digits(name: str) -> None:
    """At round-off and at a loose tolerance errors are what was asked for of the springs' motion, not of the chain's angles."""
    case = CASES[name]
    go, rest = compiled(case.chain), [0.0] * len(case.q)
    for tolerance, most in ((1e-16, 3e-14), (1e-9, 1e-9)):
        found = go(case.q, rest, 0.0, case.t, tolerance)
        assert found.outcome == "done"
        assert case.off(found.q, found.v, found.lost) < most


@pytest.mark.parametrize("name", CASES)
def test_calls_that_go_on_keep_them_too(name: str) -> None:
    """Sixteen calls, each from where the last one ended, `lost` included."""
    case = CASES[name]
    go, q, v, lost = compiled(case.chain), np.array(case.q), np.zeros(len(case.q)), None
    for k in range(16):
        found = go(q, v, k * case.t / 16, (k + 1) * case.t / 16, 1e-16, lost=lost)
        q, v, lost = found.q, found.v, found.lost
    assert lost is not None and case.off(q, v, lost) < 3e-14


def test_no_step_is_lost_to_rounding() -> None:
    """Steps in space are as many as in the plane for as much of the fast motion: rounded vectors would be taken for a changing force."""
    flat, deep = CASES["outer joint"], CASES["in space"]
    steps = [compiled(case.chain)(case.q, [0.0] * len(case.q), 0.0, case.t, 1e-16).steps / case.t for case in (flat, deep)]
    assert steps[1] < 1.5 * steps[0]


def test_trajectories_side_by_side_keep_them() -> None:
    """The batch form in space, in sixteen calls."""
    case = CASES["in space"]
    go, q, v, lost = flow(case.chain), np.array([case.q] * 3), np.zeros((3, 6)), None
    for k in range(16):
        found = go(q, v, k * case.t / 16, (k + 1) * case.t / 16, 1e-16, lost=lost)
        q, v, lost = found.q, found.v, found.lost
    assert lost is not None and all(case.off(*one) < 3e-14 for one in zip(q, v, lost, strict=True))
