"""Who serves the contract's functions: whatever writes, prints, judges or calls one registers where it is defined.

A new function is a row of the table and entries in the registries; no list of them is kept anywhere. What is missing is one
typed error, whichever it is.
"""

from __future__ import annotations

from functools import cached_property
from importlib import import_module
from pkgutil import walk_packages
from typing import Generic, TypeVar

from phichain.contract.functions import ROWS
from phichain.errors import ContractError

Entry = TypeVar("Entry")

ANY = ""
"""The variant of an entry that serves every kind of chain."""


class Registry(Generic[Entry]):
    """What a package offers for functions of the contract, by name and by the kind of chain it serves."""

    def __init__(self, package: str, what: str) -> None:
        """Start empty.

        Args:
            package: the package whose modules register their entries when they are imported.
            what: what an entry is, as an error says it: "writer".
        """
        self._package, self._what = package, what
        self._entries: dict[tuple[str, str], Entry] = {}

    def add(self, name: str, entry: Entry, variant: str = ANY, needs_row: bool = True) -> None:
        """Register what serves a function.

        Args:
            name: the function.
            entry: what serves it.
            variant: the kind of chain it serves, where there is one entry for each.
            needs_row: whether the function is one of the contract's; not so for what these call.

        Raises:
            ContractError: there is no such function, or it is served already.
        """
        if needs_row and name not in ROWS:
            problem = f"has a {self._what} and no row in the table of functions"
            raise ContractError("function", name, problem, "write its row in contract/functions.py", missing="row")
        if (name, variant) in self._entries:
            problem = f"has more than one {self._what}"
            raise ContractError("function", name, problem, "remove all but one", missing="")
        self._entries[name, variant] = entry

    def of(self, name: str, variant: str = ANY) -> Entry:
        """What serves a function on a kind of chain.

        Raises:
            ContractError: nothing does.
        """
        for key in ((name, variant), (name, ANY)):
            if key in self.entries:
                return self.entries[key]
        problem = f"has no {self._what}" + (f" for {variant} scenes" if variant else "")
        remedy = f"register one in {self._package}"
        raise ContractError("function", name, problem, remedy, missing=self._what)

    def has(self, name: str, variant: str = ANY) -> bool:
        """Whether something serves a function on a kind of chain."""
        return any(key in self.entries for key in ((name, variant), (name, ANY)))

    @cached_property
    def entries(self) -> dict[tuple[str, str], Entry]:
        """The entries, every module of the package imported."""
        package = import_module(self._package)
        for module in walk_packages(package.__path__, f"{self._package}."):
            import_module(module.name)
        return self._entries
