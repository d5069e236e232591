"""Single precision where links are held so near their joints that forces times inertias pass 3e38: a shorter second keeps them in range."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
import pytest
from mpmath import mp, mpf

from phichain.emit.c.comment import Comments
from phichain.ir import evaluate
from phichain.ir.interpret import run
from phichain.ir.rounded import arithmetic
from phichain.lowering import lower_function
from phichain.lowering.chain.time_unit import time_unit
from phichain.mechanics import derive
from phichain.scene import Scene
from tests.reference_cases import relative_error
from tests.rigs.dense import numbers, planar

#: Random rigs whose products came to 1e44, 1e39 and 1e45.
RIGS: dict[str, dict[str, Any]] = {
    "damped on a cart": {
        "links": 3, "mass": [0.0115, 2.03, 2.71], "length": [0.0408, 3.6, 0.0267], "com": [9.96e-9, 1.93e-6, 0.024],
        "damping": [4.28e-6, 120.0, 5.0e-6], "base": "cart", "cart_mass": 0.393, "cart_friction": 4.41, "cart_friction_speed": 0.0126,
        "cart_damping": 0.3, "angles": "absolute", "actuated": "all",
    },
    "rubbing on a wall": {
        "links": 4, "mass": [23.0, 0.896, 7.21, 0.0564], "length": [0.165, 0.109, 0.0637, 0.0686],
        "com": [1.22e-7, 1.87e-9, 0.0125, 2.89e-8], "friction": [0.05, 0.02, 0.1, 0.001], "friction_speed": 0.0776, "angles": "absolute",
    },
    "long before short": {
        "links": 5, "mass": [2.45, 0.0907, 0.0158, 9.81, 8.84], "length": [0.18, 44.1, 75.5, 13.0, 0.0233],
        "com": [5.18e-7, 0.0729, 1.02e-6, 4.55e-7, 2.03e-9], "friction": [0.9, 30.0, 60.0, 100.0, 0.02], "friction_speed": 0.846,
        "base": "cart", "cart_mass": 24.2, "angles": "relative",
    },
    "on a moving base": {
        "links": 4, "mass": [23.0, 0.896, 7.21, 0.0564], "length": [0.165, 0.109, 0.0637, 0.0686],
        "com": [1.22e-7, 1.87e-9, 0.0125, 2.89e-8], "stiffness": [0.5, 0.2, 0.1, 0.01], "base": "moving", "angles": "absolute",
    },
    "on a driven cart": {
        "links": 4, "mass": [23.0, 0.896, 7.21, 0.0564], "length": [0.165, 0.109, 0.0637, 0.0686],
        "com": [1.22e-7, 1.87e-9, 0.0125, 2.89e-8], "base": "cart", "drive": "acceleration", "angles": "relative",
    },
}  # fmt: skip


def rig(name: str, **more: Any) -> Scene:
    return Scene("extreme", space="planar", **{"real": "float"} | RIGS[name] | more)


@pytest.mark.parametrize("code", ["loops", "unrolled"])
@pytest.mark.parametrize("name", RIGS)
def test_single_precision_holds_what_its_answer_can(name: str, code: Literal["loops", "unrolled"]) -> None:
    """2e-6, or ten times what half a unit in the last place of every number does."""
    chain, rng = rig(name), np.random.default_rng(7)
    program = lower_function(derive(chain), "forward_dynamics", code)
    for speed in (1, 20):
        given = {
            "q": rng.uniform(-3, 3, chain.nq),
            "v": speed * rng.normal(size=chain.nv),
            "u": 3 * rng.normal(size=chain.nu),
        }
        given = {key: values.astype(np.float32) for key, values in given.items()}
        with mp.workdps(60):
            args, p = [[mpf(float(x)) for x in given[key]] for key in "qvu"], numbers(chain)
            p = {key: [mpf(float(np.float32(float(x)))) for x in values] for key, values in p.items()}
            true, amplified = planar(chain, p, *args), mpf(0)
            for _ in range(4):
                near = lambda values: [x * (1 + mpf(2) ** -80 * int(rng.choice([-1, 1]))) for x in values]
                other = planar(chain, {key: near(values) for key, values in p.items()}, *map(near, args))
                amplified = max(
                    amplified,
                    max(abs(a - b) for a, b in zip(true, other, strict=True))
                    / max(map(abs, true))
                    * mpf(2) ** 56,
                )
        found = run(
            program, arithmetic("float"), {array.name: given[array.name].tolist() for array in program.inputs}
        )["a"]
        assert relative_error(found, true) < max(2e-6, 10 * float(amplified))


def test_the_second_is_a_power_of_two_and_ordinary_chains_keep_it() -> None:
    units = {name: time_unit(rig(name)) for name in RIGS}
    assert all(
        unit.numerator == 1 and unit < 1 and unit.denominator.bit_count() == 1 for unit in units.values()
    )
    assert all(time_unit(rig(name, real="double")) == 1 for name in RIGS)
    assert (
        time_unit(
            Scene(
                "near",
                3,
                "planar",
                mass=1.0,
                length=1.0,
                com=(0.01, 0.5, 1.0),
                damping=0.1,
                actuated="all",
                real="float",
            )
        )
        == 1
    )
    assert time_unit(rig("on a driven cart", com="runtime")) == 1


def test_in_double_a_shorter_second_waits_for_numbers_far_smaller() -> None:
    chain = rig("on a driven cart", real="double", com=(1e-77,) * 4)
    assert time_unit(chain) < 1
    program = lower_function(derive(chain), "forward_dynamics", "unrolled")
    given = {
        "q": np.array([0.0, 0.3, 1.0, -0.7, 0.4]),
        "v": np.array([0.1, 0.2, -0.3, 0.4, 0.5]),
        "u": np.array([0.3]),
    }
    found = evaluate(program, given)["a"]
    with mp.workdps(400):
        true = planar(chain, numbers(chain), *([mpf(x) for x in given[key].tolist()] for key in "qvu"))
    assert relative_error(found.tolist(), true) < 1e-13


def test_the_comment_says_which_second_it_is() -> None:
    lines = ["free_0 = 1.0F;"]
    assert "What is made of rates has 1/" in "\n".join(
        Comments(rig("long before short")).above("forward_dynamics", "", lines)
    )
    assert "What is made of rates" not in "\n".join(
        Comments(rig("long before short", real="double")).above("forward_dynamics", "", lines)
    )
