"""Regulators, and rigs that are held by them."""
