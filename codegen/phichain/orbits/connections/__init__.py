"""Connections between upright equilibria of conservative planar chains, which differ by whole turns of their links."""

from phichain.orbits.connections.connect import connections
from phichain.orbits.connections.record import Connection

__all__ = ["Connection", "connections"]
