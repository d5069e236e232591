"""Proof: the Programs of a scene against the Lagrangian of its Model, exactly, in the integers modulo 2^61 - 1."""

from phichain.proof.prove import prove
from phichain.proof.record import Proof, Proven

__all__ = ["Proof", "Proven", "prove"]
