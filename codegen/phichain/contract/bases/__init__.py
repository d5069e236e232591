"""What carries a chain: the laws of bases as records, which all other layers ask instead of a base's name."""

from phichain.contract.bases.law import BaseLaw, axes_of
from phichain.contract.bases.table import FIXED, bases, drives, law_of, placed, places, with_place

__all__ = ["FIXED", "BaseLaw", "axes_of", "bases", "drives", "law_of", "placed", "places", "with_place"]
