"""Sizes of a chain whose links are unit vectors, in the plane as in space."""

from __future__ import annotations

from phichain.scene import Scene


def dimension(scene: Scene) -> int:
    """Number of components of a unit vector: 2 in the plane, 3 in space."""
    return 2 if scene.is_planar else 3


def cart_size(scene: Scene) -> int:
    """Number of the cart's coordinates: 0, 1 (planar) or 2 (spatial)."""
    return dimension(scene) - 1 if scene.has_cart else 0


def ambient_size(scene: Scene) -> int:
    """Cells of [x, q_1 .. q_N] with unit vectors in the plane as well."""
    return cart_size(scene) + dimension(scene) * scene.links
