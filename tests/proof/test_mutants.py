"""No mutant of a Program passes: one small change, and it is refused in one sentence.

A mutant that computes the same function is no fault. Those are told by another arithmetic, 50 digits at random states, and counted apart.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import mpmath
import pytest

from phichain.errors import ProofError
from phichain.ir.evaluate import evaluate_exactly
from phichain.ir.nodes import Program
from phichain.lowering import Lowered
from phichain.proof import prove
from phichain.scene import Scene
from tests.proof.chains import SCENES, lowered
from tests.proof.mutations import Mutant, mutants

LEANED_ON = {"forward_dynamics": "", "implicit_factors": "implicit_solution", "implicit_solution": "implicit_factors"}
"""What other functions are proven by, and what is proven together with it."""


def alone(whole: Lowered, program: Program) -> Lowered:
    """One function, and what it leans on."""
    others = {name: other for name, other in programs(whole).items() if name in LEANED_ON} | {program.name: program}
    return replace(whole, wanted=MappingProxyType(others), helpers=MappingProxyType({}))


def programs(whole: Lowered) -> dict[str, Program]:
    """The functions of a scene that are proven, and those that they call."""
    return {name: program for name, program in {**whole.helpers, **whole.wanted}.items() if name != "step_rosenbrock"}


def state(scene: Scene, program: Program) -> dict[str, list[Any]]:
    """Arguments of 50 digits on the manifold of the chain's states."""
    source = random.Random(program.name)

    def numbers(count: int) -> list[Any]:
        return [mpmath.mpf(source.randrange(1, 1 << 40)) / (1 << 40) for _ in range(count)]

    values = {array.name: numbers(array.size) for array in (*program.params, *program.inputs)}
    if "s" in values:
        values["s"] = [mpmath.mpf(source.choice((-1, 1))) for _ in values["s"]]
    if not scene.is_planar and "q" in values:
        carts = 2 * scene.has_cart
        for k in range(carts, scene.nq, 3):
            link = values["q"][k : k + 3]
            length = mpmath.sqrt(sum(x * x for x in link))
            values["q"][k : k + 3] = link = [x / length for x in link]
            for rate in ("v", "q_dot", "a", "right_q", "right_v"):
                if rate in values:
                    across = values[rate][k : k + 3]
                    along = sum(x * y for x, y in zip(link, across, strict=True))
                    values[rate][k : k + 3] = [x - along * y for x, y in zip(across, link, strict=True)]
    return values


def solved(whole: Lowered, factors: Program) -> dict[str, list[Any]]:
    """The solution that factors lead to, at a state with its own accelerations: what they are good for."""
    known = programs(whole)
    solution, forward = known["implicit_solution"], known["forward_dynamics"]
    given = state(whole.model.scene, factors) | state(whole.model.scene, solution)
    given |= {name: values for name, values in state(whole.model.scene, forward).items()}
    given |= evaluate_exactly(forward, given)
    return evaluate_exactly(solution, given | evaluate_exactly(factors, given))


def computes_the_same(whole: Lowered, mutant: Program) -> bool:
    with mpmath.workdps(50):
        program = programs(whole)[mutant.name]
        given = state(whole.model.scene, program)

        def results(of: Program) -> dict[str, list[Any]]:
            return solved(whole, of) if of.name == "implicit_factors" else evaluate_exactly(of, given)

        true = results(program)
        try:
            found = results(mutant)
        except (KeyError, ZeroDivisionError):
            return False
        pairs = [pair for name in true for pair in zip(true[name], found[name], strict=True)]
        return all(abs(a - b) <= mpmath.mpf(10) ** -40 * (1 + abs(a)) for a, b in pairs)


def program_mutants(name: str) -> Iterator[Mutant]:
    whole = lowered(name)
    for program in programs(whole).values():
        yield from mutants(program, per_kind=1)


@pytest.mark.long
@pytest.mark.parametrize("name", SCENES)
def test_every_mutant_of_a_program_is_refused(name: str) -> None:
    whole = lowered(name)
    refused, same, missed = Counter[str](), Counter[str](), []
    for mutant in program_mutants(name):
        try:
            prove(whole.model, alone(whole, mutant.program))
        except ProofError as refusal:
            assert mutant.program.name in (refusal.function, LEANED_ON.get(refusal.function))
            assert str(refusal.point) in refusal.problem
            refused[mutant.kind] += 1
        else:
            if computes_the_same(whole, mutant.program):
                same[mutant.kind] += 1
            else:
                missed.append(f"{mutant.program.name}: {mutant.kind}")
    print(name, sum(refused.values()), dict(same))
    assert not missed
    assert sum(refused.values()) >= 25, refused
    assert sum(same.values()) <= sum(refused.values()) // 4, same
