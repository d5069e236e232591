"""Whether there is memory for what is asked, said before anything is computed."""

from __future__ import annotations

import os
from typing import Any, Final

import numpy as np

from phichain.errors import ArrayError


def demand_room(field: str, count: int, size: int, kind: np.dtype[Any]) -> None:
    """Refuse a batch whose results this machine could never hold, before anything is computed.

    Args:
        field: What asks for them, for the message.
        count: Number of its rows.
        size: Numbers that each takes.
        kind: Their type.

    Raises:
        ArrayError: They need more memory than there is.
    """
    wanted = count * size * kind.itemsize
    if wanted > _ASK_FROM and wanted > (there := memory()):
        problem = f"asks for {wanted / 2**30:.3g} GiB at once, and this machine has {there / 2**30:.3g}"
        raise ArrayError(field, count, problem, "give it in pieces")


def memory() -> int:
    """Bytes of this machine's memory."""
    return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


_ASK_FROM: Final = 2**28
