"""Families of orbits and frequency responses beside their peers."""
