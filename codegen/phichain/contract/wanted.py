"""What a scene wants of the contract's functions, checked."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from phichain.contract.chain import Kind
from phichain.contract.functions import FUNCTIONS, ROWS
from phichain.contract.words import nearest
from phichain.errors import SceneError, UnsupportedError

_PLANNED: Final = {
    "controller": 'compute the gains from "linearization" until then',
}


def wanted(value: object, kind: Kind) -> tuple[str, ...]:
    """Check a list of wanted functions and return it in the contract's order, each name once.

    Args:
        value: The list of names.
        kind: What the scene is.

    Raises:
        SceneError: The value is no list of names, or a name is unknown (the nearest one is given).
        UnsupportedError: A function is not defined for such a scene (what to use instead is given).
    """
    label = "functions.want"
    if isinstance(value, str) or not isinstance(value, Sequence):
        raise SceneError(label, value, "is not a list of function names", 'write want = ["forward_dynamics"]')
    for name in value:
        _check_function(label, name, kind)
    if not value:
        raise SceneError(label, value, "asks for no function", 'write want = ["forward_dynamics"]')
    return tuple(name for name in FUNCTIONS if name in value)


def _check_function(label: str, name: object, kind: Kind) -> None:
    """Refuse what is no function, or none of such a scene.

    Raises:
        SceneError: It is no name of a function.
        UnsupportedError: Such a scene has no such function.
    """
    if not isinstance(name, str):
        raise SceneError(label, name, "holds what is no function name", 'write want = ["forward_dynamics"]')
    if name in _PLANNED:
        raise UnsupportedError(label, name, "is not available in this version", _PLANNED[name])
    if name not in ROWS:
        best = nearest(name, FUNCTIONS)
        remedy = f'did you mean "{best}"? The functions are {", ".join(FUNCTIONS)}'
        raise SceneError(label, name, "is not a function", remedy, nearest=best)
    reason = ROWS[name].absence(kind)
    if reason is not None:
        raise UnsupportedError(label, name, reason.problem, reason.remedy)
