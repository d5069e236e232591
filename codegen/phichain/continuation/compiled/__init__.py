"""Continuation of problems that are compiled: what they offer, and how a run goes by it."""
