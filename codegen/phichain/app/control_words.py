"""Words of `phichain controller` and `swingup` as what control takes: weights, sensors, integrals, poles, equilibria, by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from phichain.contract.words import known_names
from phichain.errors import ArrayError, UnsupportedError

if TYPE_CHECKING:
    from phichain.control import Sensors
    from phichain.system import System

Words = list[str] | None


def weighed(system: System, state: float, push: float, words: Sequence[str]) -> tuple[list[float], list[float]]:
    """The diagonals of Q and R: one weight for all, others by name.

    Args:
        system: Whose state and inputs they weigh.
        state: Weight of every entry of the state.
        push: Weight of every input.
        words: NAME=W, the name of an entry of (q, v) in the plane, of the coordinates of (19) in space, or of an input.

    Raises:
        ArrayError: A word is not of that kind, or names nothing that is weighed.
    """
    from phichain.control import linearize

    names = linearize(system, (1,) * system.links).state_names
    alias = dict(zip((*system.q_names, *system.v_names), names, strict=True)) if system.is_planar else {}
    known = {**{name: (0, i) for i, name in enumerate(names)}, **{name: (1, i) for i, name in enumerate(system.u_names)}}
    diagonals = [state] * len(names), [push] * system.nu
    for word in words:
        name, _, text = word.partition("=")
        at = known.get(alias.get(name.strip(), name.strip()))
        if at is None:
            raise ArrayError("weight", word, "weighs nothing of this chain", known_names(name, tuple(known)))
        try:
            diagonals[at[0]][at[1]] = float(text)
        except ValueError:
            raise ArrayError("weight", word, "has no number behind its name", f"write {name}=100") from None
    return diagonals


def by_name(field: str, words: Sequence[str], usual: float | None = None) -> dict[str, float]:
    """Numbers by name from words like `theta_1=0.001`.

    Args:
        field: What they are, for messages.
        words: NAME=NUMBER.
        usual: The number of a name that stands alone; None where none may.

    Raises:
        ArrayError: A word is not of that kind, or names something again.
    """
    found: dict[str, float] = {}
    for word in words:
        name, equals, text = (part.strip() for part in word.partition("="))
        try:
            value = float(text) if equals or usual is None else usual
        except ValueError:
            raise ArrayError(field, word, "is not NAME=NUMBER", f"write for example --{field} theta_1=0.001") from None
        if not name or name in found:
            raise ArrayError(field, word, "names nothing, or something again", "name each once")
        found[name] = value
    return found


def for_all_or_by_name(field: str, words: Sequence[str]) -> float | Mapping[str, float] | None:
    """One number for all, or numbers by name; None where there is no word.

    Raises:
        ArrayError: As `by_name`, or a number for all stands beside others.
    """
    if len(words) == 1 and "=" not in words[0]:
        try:
            return float(words[0])
        except ValueError:
            raise ArrayError(field, words[0], "is no number and no NAME=NUMBER", f"write --{field} 0.001 or --{field} x=0.001") from None
    return by_name(field, words) if words else None


def poles(text: str) -> list[complex]:
    """Complex numbers separated by commas or spaces, like `-2,-3+1j,-3-1j`.

    Raises:
        ArrayError: Something between the commas is no number.
    """
    try:
        return [complex(word.replace("i", "j")) for word in text.replace(",", " ").split()]
    except ValueError:
        raise ArrayError("poles", text, "is not a list of numbers", "write them like -2,-3,-4+1j,-4-1j") from None


def equilibria(text: str, links: int) -> list[tuple[int, ...]] | None:
    """Equilibria by the links that stand, separated by semicolons: `none;2;all`; None for `all`, every one there is.

    Raises:
        ArrayError: One names a link that is not there, or stands there twice.
    """
    from phichain.system.starts import upright

    if text.strip() == "all":
        return None
    found = [upright(word.strip(), links) for word in text.split(";") if word.strip()]
    if not found or len(set(found)) < len(found):
        raise ArrayError("table", text, "names no equilibrium, or one twice", 'write "all", or for example "none;2;1,2"')
    return found


def sensors_of(measured: str | None, resolution: Words, noise: Words, disturbance: Words) -> Sensors:
    """What is measured and how well, as options say it; what they leave out is as `Sensors` has it.

    Raises:
        ArrayError: As `for_all_or_by_name`.
    """
    from phichain.control import Sensors

    words = {"resolution": resolution, "noise": noise, "disturbance": disturbance}
    given = {name: for_all_or_by_name(name, said or []) for name, said in words.items()}
    names = None if measured is None else tuple(measured.replace(",", " ").split())
    return Sensors(names, **{name: value for name, value in given.items() if value is not None})


def demand_together(field: str, value: object, others: Mapping[str, object]) -> None:
    """Refuse what says something of a thing that is not asked for.

    Raises:
        UnsupportedError: One of the others is given, and the thing is not.
    """
    for name, given in others.items():
        if value is None and given is not None:
            raise UnsupportedError(name, given, f"says something of --{field}, which is not asked for", f"give --{field} too")
