"""Planar sweeps that hand outwards what stretches the chain beyond, beside an acceleration."""
