"""THE table of bases: a new one is a row, if it is one of those that `BaseLaw` can say."""

from __future__ import annotations

from typing import Final

from phichain.contract.bases.law import BaseLaw

_WALL: Final = "  ///////"
_CART: Final = ("  ._____.", "  |_____|", "   O   O")

FIXED: Final = BaseLaw(
    base="fixed", drive=None, placed="none", told="none", on="on a fixed base", noun="fixed base", drawing=(_WALL,),
    left_out="the base is fixed",
)  # fmt: skip

#: All of them; of one base's laws the one that it has unless `drive` says another comes first.
LAWS: Final[tuple[BaseLaw, ...]] = (
    FIXED,
    BaseLaw(
        base="cart", drive="force", placed="horizontal", told="none", on="on a cart", noun="cart", drawing=_CART,
        input="force", unit="N", meaning="horizontal force on the cart, N", place="cart", driven="the force on the cart",
    ),
    BaseLaw(
        base="cart", drive="acceleration", placed="horizontal", told="horizontal", on="on a cart",
        noun="cart driven by its acceleration b", drawing=_CART, input="acceleration", unit="m/s^2",
        meaning="acceleration of the cart, m/s^2", place="cart", driven="the acceleration of the cart",
    ),
    BaseLaw(
        base="moving", drive=None, placed="none", told="all", on="on a moving base",
        noun="base that moves with velocity c and acceleration b", drawing=("  ^ <-> v  base_acceleration", _WALL),
        input="base_acceleration", unit="m/s^2", meaning="acceleration of the base, {size} components, the last one down, m/s^2",
        place="base", driven="the acceleration of the base", argument="acceleration of the base, the last component down, m/s^2",
        left_out="the base is moved, and has no equation of its own",
    ),
)  # fmt: skip


def law_of(base: str, drive: str | None = None) -> BaseLaw:
    """The law of a base by the words of a scene; None of `drive` means what the base has unless said."""
    return next(law for law in LAWS if law.base == base and drive in (None, law.drive))


def bases() -> tuple[str, ...]:
    """The words of `chain.base`."""
    return tuple(dict.fromkeys(law.base for law in LAWS))


def drives(base: str) -> tuple[str, ...]:
    """The words of `chain.drive` on a base; none where it has no such choice."""
    return tuple(law.drive for law in LAWS if law.base == base and law.drive is not None)


def placed() -> tuple[str, ...]:
    """The bases that have coordinates."""
    return tuple(dict.fromkeys(law.base for law in LAWS if law.is_placed))


def places() -> tuple[str, ...]:
    """The words of `forcing.forced` that mean a base."""
    return tuple(dict.fromkeys(law.place for law in LAWS if law.place is not None))


def with_place(place: str) -> tuple[str, ...]:
    """The bases that a word of `forcing.forced` can mean."""
    return tuple(dict.fromkeys(law.base for law in LAWS if law.place == place))
