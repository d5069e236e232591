"""The proof of a scene: its Lagrangian against the masses' positions, then every Program against the Lagrangian."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

from phichain.contract.functions import FLOWS
from phichain.errors import ProofError
from phichain.lowering import Lowered, lower
from phichain.lowering.dynamics import form_of_many
from phichain.lowering.field import vector_field
from phichain.lowering.lower import lower_function
from phichain.lowering.preparation import preparation
from phichain.lowering.series import Series, series
from phichain.lowering.steps.rosenbrock import increment_of
from phichain.mechanics import Model, derive
from phichain.proof.case import IDENTITIES, Case, Subject, Wrong
from phichain.proof.equations import check_equations
from phichain.proof.identities.dynamics import field_of_flows
from phichain.proof.identities.expansion import ORDERS, Recurrences
from phichain.proof.identities.recurrences import recurrences
from phichain.proof.lagrange import Judge
from phichain.proof.model import check_lagrangian
from phichain.proof.modular.points import POINTS, Point
from phichain.proof.positions import Chain
from phichain.proof.record import Proof, Proven
from phichain.scene import Scene

EXACTLY: Final = f"modulo 2^61 - 1, {POINTS} points"
"""How a function is proven."""

_BY_DIGITS: Final = "50 digits in the self-test: no identity modulo a prime is written for it"
_FLOW: Final = f"50 digits in the self-test: steps in floating point; its vector field {EXACTLY}"
_RECURRENCES: Final = f"50 digits in the self-test: steps in floating point; its recurrences {EXACTLY}, {ORDERS} orders"
_PREPARED: Final = "prepare"
_BATCH: Final = "forward_dynamics_batch"
_TAYLOR: Final = frozenset({"propagate", "propagate_batch"})
_REMEDY: Final = "nothing was written: report this scene, or give prove=False (--no-proof) to have it unproven"


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
    chains = tuple(Chain(Point(model.scene, number + 1, lowered.params)) for number in range(POINTS))
    check_lagrangian(model, judge, chains)
    check_equations(model, judge, chains, lowered.params)
    court = _Court(model, lowered, judge, chains)
    # What others call comes first, so that a fault is named where it is.
    found = [court.proven(name) for name in (*lowered.helpers, *lowered.wanted)]
    found += court.flows()
    return Proof(model.scene.name, model.scene.digest, tuple(found), time.process_time() - start)


def prove_recurrences(model: Model, made: Series) -> Proven:
    """Prove the Taylor recurrences of a Model against its Lagrangian, as truncated power series in the field.

    Args:
        model: the chain's mechanics.
        made: its recurrences.

    Raises:
        ProofError: the motion they expand is not the Lagrangian's.
    """
    start, params = time.process_time(), made.factor.params
    points = [Point(model.scene, number + 1, params) for number in range(POINTS)]
    _hold_recurrences(model, made, Judge(model, params), points)
    return Proven("recurrences", f"{EXACTLY}, {ORDERS} orders", True, time.process_time() - start)


def _hold_recurrences(model: Model, made: Series, judge: Judge, points: Sequence[Point]) -> None:
    programs = Recurrences.of(made)
    for point in points:
        try:
            recurrences(programs, judge, point)
        except Wrong as fault:
            raise ProofError(
                f"{model.scene.name}.recurrences", str(fault), f"do not meet the Lagrangian at random point {point.number}", _REMEDY,
                function="recurrences", output=str(fault), point=point.number, digest=model.scene.digest,
            ) from None  # fmt: skip


@dataclass(eq=False)
class _Court:
    """The Programs of one Model before its judge."""

    model: Model
    lowered: Lowered
    judge: Judge
    chains: tuple[Chain, ...]

    def proven(self, name: str) -> Proven:
        """Prove one function.

        Raises:
            ProofError: it does not meet its identity.
        """
        start, space = time.process_time(), self.model.scene.space
        if not IDENTITIES.has(name, space):
            return Proven(name, _BY_DIGITS, False)
        self.hold(name, self.subjects[name], IDENTITIES.of(name, space))
        return Proven(name, EXACTLY, True, time.process_time() - start)

    def flows(self) -> list[Proven]:
        """What stands in for the flows, which are C around Programs: Taylor recurrences, or the vector field of the scene.

        Raises:
            ProofError: they are not the Lagrangian's.
        """
        wanted = [name for name in self.model.scene.want if name in FLOWS and name != _PREPARED]
        start, by_field = time.process_time(), [name for name in wanted if name not in _TAYLOR]
        if by_field:
            self.hold(by_field[0], Subject(vector_field(self.model)), field_of_flows)
            if "propagate_stiff" in by_field and increment_of(self.model.scene) == "bent_increment":
                self.other("bent_dynamics")
        if _BATCH in wanted:
            self.other(form_of_many(self.model.scene))
        middle = time.process_time()
        if len(by_field) < len(wanted):
            _hold_recurrences(self.model, series(self.model), self.judge, [chain.point for chain in self.chains])
        seconds = {False: middle - start, True: time.process_time() - middle}
        return self.prepared() + [
            Proven(name, _RECURRENCES if name in _TAYLOR else _FLOW, False, seconds[name in _TAYLOR]) for name in wanted
        ]

    def prepared(self) -> list[Proven]:
        """Both parts of the forward dynamics, one after the other, are the Lagrangian's.

        Raises:
            ProofError: they are not.
        """
        if _PREPARED not in self.model.scene.want:
            return []
        start, identity = time.process_time(), IDENTITIES.of("forward_dynamics", self.model.scene.space)
        self.hold(_PREPARED, Subject(preparation(self.model).whole), identity)
        return [Proven(_PREPARED, EXACTLY, True, time.process_time() - start)]

    def hold(self, name: str, subject: Subject, identity: Callable[[Case], None]) -> None:
        """Hold a Program against its identity at every point.

        Raises:
            ProofError: it does not meet it; names the function, the output and the point.
        """
        for chain in self.chains:
            number = chain.point.number
            try:
                identity(Case(subject, self.other, self.judge, chain))
            except Wrong as fault:
                raise ProofError(
                    f"{self.model.scene.name}.{name}", str(fault), f"does not meet the Lagrangian at random point {number}", _REMEDY,
                    function=name, output=str(fault), point=number, digest=self.model.scene.digest,
                ) from None  # fmt: skip

    @cached_property
    def subjects(self) -> dict[str, Subject]:
        """The Programs by name."""
        return {name: Subject(program) for name, program in (*self.lowered.helpers.items(), *self.lowered.wanted.items())}

    def other(self, name: str) -> Subject:
        """A Program that others lean on: proven as one of the scene's functions, or here where it is none."""
        if name not in self.subjects:
            self.subjects[name] = Subject(lower_function(self.model, name, "loops"))
            self.proven(name)
        return self.subjects[name]
