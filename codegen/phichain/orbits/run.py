"""How one family is followed, whatever its method: what all of them take besides the chain, where it begins and where it is to end."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from phichain.continuation import Branch, Engine
from phichain.continuation.core import Progress
from phichain.errors import ArrayError
from phichain.records import Shown, frozen
from phichain.system import Parameters, System


@dataclass(frozen=True)
class Run:
    """What a run of any method takes.

    Attributes:
        engine: Predictor, corrector and options.
        p: Runtime parameters.
        amplitude_start: Largest angle, rad, by which the first point is off where the family begins.
        through: Half width of gaps that are crossed.
        earlier: A run to go on with.
        progress: Told every new point.
    """

    engine: Engine
    p: Parameters | None = None
    amplitude_start: float = 1e-2
    through: float = 0.0
    earlier: Branch | None = None
    progress: Progress | None = None


def demand_same(system: System, earlier: Shown, facts: Iterable[tuple[str, Any, Any]], kinds: str, p: Parameters | None) -> None:
    """Refuse to go on with a family or a response of another kind.

    Args:
        system: The chain.
        earlier: What is to be gone on with.
        facts: What is to be the same: its name, what the record says, and what is wanted.
        kinds: These in words.
        p: Runtime parameters.

    Raises:
        ArrayError: One differs, or a runtime parameter's value does.
    """
    of, made = ("branch", "traced") if isinstance(earlier, Branch) else ("response", "followed")
    for field, own, wanted in facts:
        if own != wanted:
            raise ArrayError(
                "resume", own, f"is the {field} of that {of}, and {wanted!r} is wanted here{_differing(system, earlier) if field == 'digest' else ''}", f"resume it with the {kinds} that it was {made} with",
            )  # fmt: skip
    demand_same_values("resume", system, earlier, p)


def _differing(system: System, earlier: Shown) -> str:
    """What is different about the scene of a family or a response, as far as that says: its name, its coordinates, its runtime parameters, or else what it does not keep."""
    coordinates = system.q_names
    if coordinates and isinstance(earlier, Branch) and earlier.closing == "quarter":
        coordinates = tuple(earlier.names[:-1])
    pairs = (
        ("name", (getattr(earlier, "scene", "") or system.name,), (system.name,)), ("coordinates", coordinates, system.q_names),
        ("runtime parameters", tuple(sorted(earlier.p)), tuple(sorted(system.params or {}))),
    )  # fmt: skip
    said = [f"its {what} {' and '.join(own) or 'none'} there, {' and '.join(here) or 'none'} here" for what, own, here in pairs if own != here]
    return f": of the scene differ {'; '.join(said)}" if said else ": the scene has that name, but other numbers, functions or options"


def demand_same_values(field: str, system: System, branch: Shown, p: Parameters | None) -> None:
    """Refuse to go on from a family of the same scene whose runtime parameters had other values.

    Raises:
        ArrayError: They had, as far as the family says.
    """
    given, of = frozen(system.values(p)), "family" if isinstance(branch, Branch) else "response"
    for name, own in branch.p.items():
        if name in given and given[name] != own and not is_each(own, given[name]):
            raise ArrayError(
                f"{field}.p.{name}", own, f"is the {name} of that {of}, and {given[name]} is given here", f"give the values that it was {'traced' if of == 'family' else 'followed'} with",
            )


def is_each(own: object, given: object) -> bool:
    """Whether one number and a list say the same of every link."""
    one, many = (own, given) if isinstance(given, tuple) else (given, own)
    return isinstance(many, tuple) and all(entry == one for entry in many)
