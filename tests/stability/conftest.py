"""Fixtures shared with the tests of the other tables."""

from tests.benchmarks.conftest import no_peers

__all__ = ["no_peers"]
