"""Networks of families: what opens at every event, and how families hang together."""

from phichain.orbits.network.record import Link, Network

__all__ = ["Link", "Network"]
