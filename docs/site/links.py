"""Addresses outside the repository: `python -m docs.site.links` asks each whether it is there; without a network it says so.

Every address that pages, code and templates name stands in `KNOWN`, with what it leads to, and nowhere else is it decided whether one may be named.
The tests hold the repository against this table without a network: nothing that is not in it, nothing in it that is not named, every one well formed.
"""

from __future__ import annotations

import re
import sys
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Final
from urllib.parse import urlsplit

ROOT: Final = Path(__file__).resolve().parents[2]
KNOWN: Final = {
    "https://doi.org/10.1109/CDC.2012.6427059": "paper B at its publisher's",
    "https://github.com/meco-group/fatrop": "the solver fatrop",
    "https://keepachangelog.com/en/1.1.0/": "the form of the changelog",
    "https://semver.org/spec/v2.0.0.html": "what version numbers mean",
    "http://www.apache.org/licenses/": "the licence, as its own text names it",
    "http://www.apache.org/licenses/LICENSE-2.0": "the licence, as its own text names it",
    "https://json-schema.org/draft/2020-12/schema": "the name of the schema's language, which editors know and nobody fetches",
    "https://raw.githubusercontent.com/platformio/platformio-core/develop/platformio/assets/schema/library.json": "PlatformIO's schema of library.json",
    "https://example.org/{{": "the address that an Arduino library must have, in the domain that is reserved for examples: its owner puts in his own",
}
"""Address -> what it leads to."""
NOT_FETCHED: Final = ("https://json-schema.org/", "https://example.org/")
"""Beginnings of addresses that are names."""
_LOOKED: Final = ("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "CITATION.cff", "LICENSE", "NOTICE", "pyproject.toml", "Makefile")
_FOLDERS: Final = ("codegen", "docs", "templates", "stencils", "scenes", "examples", "benchmarks", "generated/reference")
_SUFFIXES: Final = (".md", ".py", ".j2", ".toml", ".html", ".js", ".c", ".h", ".txt")
_ADDRESS: Final = re.compile(r"(?:https?|ftp)://[^\s)\"'>`\\,;}]+|\bwww\.[a-z][^\s)\"'>`\\]+")
_SECONDS: Final = 20


def named(root: Path = ROOT) -> Iterator[tuple[Path, str]]:
    """Every address in what is shipped, with the file that names it; this table apart."""
    folders = (path for folder in _FOLDERS for path in sorted((root / folder).rglob("*")) if path.suffix in _SUFFIXES)
    for path in (*(root / name for name in _LOOKED), *folders):
        if path.is_file() and path.resolve() != Path(__file__).resolve():
            for match in _ADDRESS.finditer(path.read_text(encoding="utf-8", errors="replace")):
                yield path.relative_to(root), match[0].rstrip(".:")


def faults(root: Path = ROOT) -> list[str]:
    """What is wrong with the addresses, as far as that can be told without a network."""
    used = list(named(root))
    found = [f"{path}: {address} is not in docs/site/links.py" for path, address in used if address not in KNOWN]
    found += [f"docs/site/links.py: {address} is named nowhere" for address in sorted(KNOWN.keys() - {address for _, address in used})]
    return found + [f"docs/site/links.py: {address} is no address" for address in KNOWN if not _is_address(address)]


def _is_address(text: str) -> bool:
    parts = urlsplit(text)
    host = parts.hostname or ""
    is_doi = host != "doi.org" or re.fullmatch(r"/10\.\d{4,9}/\S+", parts.path) is not None
    return parts.scheme in ("http", "https") and re.fullmatch(r"([a-z0-9-]+\.)+[a-z]{2,}", host) is not None and is_doi


def answer(address: str) -> str:
    """What an address answers: empty where it is there, else why not.

    Raises:
        OSError: No network.
    """
    request = urllib.request.Request(address, method="HEAD", headers={"User-Agent": "phichain documentation"})
    try:
        with urllib.request.urlopen(request, timeout=_SECONDS):
            return ""
    except urllib.error.HTTPError as refusal:
        # Publishers turn programs away; a page that is gone says so.
        return str(refusal) if refusal.code in (404, 410) else ""


def main() -> int:
    """Ask every address; the number of those that are gone."""
    found = faults()
    for address in KNOWN:
        if address.startswith(NOT_FETCHED):
            continue
        try:
            problem = answer(address)
        except OSError as failure:
            print(f"no network to ask in ({getattr(failure, 'reason', failure)}): addresses are held against docs/site/links.py alone")
            break
        found += [f"{address}: {problem}"] if problem else []
    for fault in found:
        print(fault, file=sys.stderr)
    print(f"{len(KNOWN)} addresses, {len(found)} at fault")
    return min(len(found), 100)


if __name__ == "__main__":
    sys.exit(main())
