"""The proof of a scene: its Lagrangian against the masses' positions, then every Program against the Lagrangian."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import cache

from phichain.contract.functions import FLOWS
from phichain.errors import ProofError
from phichain.ir.nodes import Program
from phichain.lowering import Lowered, lower
from phichain.lowering.lower import lower_function
from phichain.mechanics import Model, derive
from phichain.proof.case import IDENTITIES, Case, Subject, Wrong
from phichain.proof.lagrange import Judge
from phichain.proof.model import check_lagrangian
from phichain.proof.points import POINTS, Point
from phichain.proof.positions import Chain
from phichain.proof.record import Proof, Proven
from phichain.scene import Scene

EXACTLY = f"modulo 2^61 - 1, {POINTS} points"
"""How a function is proven."""

_REMEDY = "nothing was written: report this scene, or give prove=False (--no-proof) to have it unproven"


def prove(of: Scene | Model, lowered: Lowered | None = None) -> Proof:
    """Prove the Programs of a Model against its Lagrangian, exactly (docs/theory.md, "The proof").

    Args:
        of: a Model, whose T, V and dissipation are held against the positions of the masses first; or a scene, to be derived.
        lowered: its Programs; lowered here where none are given.

    Returns:
        For each function how it was proven; steps that are no rational map, and flows, say what stands in.

    Raises:
        ProofError: the Lagrangian, or a function, does not meet its identity.
    """
    model = of if isinstance(of, Model) else derive(of)
    lowered = lower(model) if lowered is None else lowered
    start = time.process_time()
    judge = Judge(model, lowered.params)
    chains = [Chain(Point(model.scene, number + 1, lowered.params)) for number in range(POINTS)]
    check_lagrangian(model, judge, chains)
    # What others call comes first, so that a fault is named where it is.
    programs = {**lowered.helpers, **lowered.wanted}

    @cache
    def forward() -> Subject:
        if _FORWARD in programs:
            return Subject(programs[_FORWARD])
        program = lower_function(model, _FORWARD, "loops")
        _proven(program, forward, judge, chains)
        return Subject(program)

    proven = [_proven(program, forward, judge, chains) for program in programs.values()]
    flows = [Proven(name, _FLOW, False) for name in model.scene.want if name in FLOWS]
    return Proof(model.scene.name, model.scene.digest, (*proven, *flows), time.process_time() - start)


_FORWARD = "forward_dynamics"
_FLOW = "50 digits: steps in floating point; the forward dynamics that it calls are proven as forward_dynamics are"


def _proven(program: Program, forward: Callable[[], Subject], judge: Judge, chains: list[Chain]) -> Proven:
    """Prove one function.

    Raises:
        ProofError: it does not meet its identity.
    """
    start, name = time.process_time(), program.name
    if not IDENTITIES.has(name, judge.scene.space):
        return Proven(name, "50 digits: no identity modulo a prime is known for it", False)
    identity = IDENTITIES.of(name, judge.scene.space)
    subject = Subject(program)
    for chain in chains:
        try:
            identity(Case(subject, forward, judge, chain))
        except Wrong as fault:
            raise ProofError(
                f"{judge.scene.name}.{name}", str(fault), f"does not meet the Lagrangian at random point {chain.point.number}", _REMEDY,
                function=name, output=str(fault), point=chain.point.number, digest=judge.scene.digest,
            ) from None  # fmt: skip
    return Proven(name, EXACTLY, True, time.process_time() - start)
