"""Where pictures and pages come from, as their files can say it: the words of `phichain.origin`, in the form that each kind of file has for them.

| file | where |
|---|---|
| PNG | text `Description`, and `Software` |
| SVG, PDF | Description and Creator; Subject and Creator |
| GIF | a comment before the first picture |
| MP4 | the comment of its container |
| HTML | `<script type="application/json" id="origin">`, which no browser runs |
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any, Final

from phichain._version import __version__
from phichain.origin import WROTE, origin, plain

MADE_BY: Final = f"phichain {__version__}"
_BLOCK: Final = 255
"""Bytes that one block of a GIF's comment holds at most."""


def told(of: Any = None) -> str:
    """One line of JSON: where a record comes from; a list of it for several; the version alone for none.

    Args:
        of: A record; several; what is said of one, by name; or nothing.
    """
    several = isinstance(of, Iterable) and not isinstance(of, Mapping)
    return json.dumps([_of(record) for record in of] if several else _of(of))


def _of(record: Any) -> dict[str, Any]:
    """Where one record comes from, or what is said of it already."""
    if record is None or isinstance(record, Mapping):
        return {WROTE: __version__, **plain(record or {})}
    return origin(record)


def metadata(kind: str, text: str) -> dict[str, Any]:
    """What matplotlib writes into a picture besides it; no time, so that the same figure is the same file."""
    if kind == ".svg":
        return {"Date": None, "Creator": MADE_BY, "Description": text}
    if kind == ".pdf":
        return {"CreationDate": None, "Creator": MADE_BY, "Subject": text}
    return {"Software": MADE_BY, "Description": text}


def in_gif(picture: bytes, text: str) -> bytes:
    """A GIF with a comment before its first picture, where all readers look for one."""
    content = text.encode()
    blocks = b"".join(bytes([len(part)]) + part for at in range(0, len(content), _BLOCK) if (part := content[at : at + _BLOCK]))
    # Behind the screen's description, 13 bytes, and the colours of all pictures, three bytes each, where there are any.
    first = 13 + (3 * 2 ** ((picture[10] & 7) + 1) if picture[10] & 0x80 else 0)
    return b"".join([picture[:first], b"\x21\xfe", blocks, b"\x00", picture[first:]])


def in_page(text: str) -> str:
    """An element of a page that holds it as data."""
    # A "<" could end the element early, and JSON may say it otherwise.
    return f'<script type="application/json" id="origin">{text.replace("<", chr(92) + "u003c")}</script>'
