"""The Model itself: its Lagrangian against the positions of the masses, its coefficients and what it shows against the Lagrangian."""

from __future__ import annotations

from collections.abc import Sequence

from phichain.errors import ProofError
from phichain.mechanics import Model
from phichain.proof.lagrange import BASE_RATE, Judge, along_told
from phichain.proof.modular.field import PRIME
from phichain.proof.modular.points import Point
from phichain.proof.positions import Chain

_REMEDY = "nothing was written: derive the model from its scene anew"
_NAMES = {
    "kinetic": "T",
    "weight": "V (gravity)",
    "potential": "V",
    "dissipation": "R",
    "positions": "positions",
}


def check_lagrangian(model: Model, judge: Judge, chains: Sequence[Chain]) -> None:
    """Hold T, V, R and the positions, and the coefficients that the judge uses, at every point.

    Raises:
        ProofError: one of them is not what the positions of the masses say.
    """
    for chain in chains:
        point, found = chain.point, judge.energies(chain.point, drift=True)
        drift = along_told(model.scene, judge.drift(point).get(BASE_RATE, [])) if model.scene.is_moving else ()
        for name, true in chain.energies(drift).items():
            if any((a - b) % PRIME for a, b in zip(found[name], true, strict=True)):
                raise _wrong(model, _NAMES[name], "is not what the positions of the masses say", point)
        if (chain.collected_kinetic(drift) - found["kinetic"][0]) % PRIME:
            raise _wrong(model, "T", "has other coefficients than M00, mu_k and c_ij", point)


def _wrong(model: Model, what: str, problem: str, point: Point) -> ProofError:
    return ProofError(
        f"{model.scene.name}: {what}", "another value", f"{problem}, at random point {point.number}", _REMEDY,
        function="", output=what, point=point.number, digest=model.scene.digest,
    )  # fmt: skip
