"""Proof: the Programs of a scene against the Lagrangian of its Model, exactly, in the integers modulo 2^61 - 1."""

from phichain.proof.prove import EXACTLY, prove
from phichain.proof.record import Proof, Proven

__all__ = ["EXACTLY", "Proof", "Proven", "prove"]
