"""A generated folder as a package of an ecosystem: CMake, Zephyr, PlatformIO, Arduino, with a bill of materials beside it."""

from __future__ import annotations

import hashlib
import json
import re
import uuid
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, Final

from phichain._version import __version__
from phichain.contract.words import nearest
from phichain.emit.render import render
from phichain.errors import UnsupportedError
from phichain.files import MANIFEST, SELFTEST_HOOK

#: Namespace of the serial numbers of bills of materials: one a scene, the same whenever it is generated.
_SERIALS: Final = uuid.uuid5(uuid.NAMESPACE_URL, "phichain")

Files = dict[str, str]


def packaged(kind: str, texts: Mapping[str, str]) -> Files:
    """The files of a package, by path.

    Args:
        kind: "cmake", "zephyr", "platformio" or "arduino".
        texts: the generated folder, by file name.

    Raises:
        UnsupportedError: there is no such kind.
    """
    known_kind(kind)
    record = json.loads(texts[MANIFEST])
    names = _names(record, texts)
    files = {**KINDS[kind](record["name"], texts, names), "README.md": texts["README.md"]}
    files[f"{record['name']}.cdx.json"] = bill_of_materials(record, files)
    return files | {MANIFEST: _manifest(record, kind, files)}


def known_kind(kind: str) -> None:
    """Go on only with a kind of package that there is.

    Raises:
        UnsupportedError: it is none.
    """
    if kind not in KINDS:
        best = nearest(kind, tuple(KINDS))
        guess = f' (did you mean "{best}"?)' if best else ""
        raise UnsupportedError("package", kind, "is no kind of package", f"use {', '.join(KINDS)}{guess}", nearest=best)


def _names(record: Mapping[str, Any], texts: Mapping[str, str]) -> dict[str, object]:
    """What the templates ask for."""
    costs = [row["cortex_m4f_at_most"] for row in (*record["functions"].values(), *record["flows"].values())]
    return {
        "name": record["name"], "upper": record["name"].upper(), "version": semantic(__version__),
        "flash": sum(cost["flash_Os"] for cost in costs) + record["sincos_flash_at_most"], "stack": max(cost["stack"] for cost in costs),
        "hook": SELFTEST_HOOK in texts and record["scene"]["target"]["trig_hook"],
        "needs_math": "#include <math.h>" in texts[f"{record['name']}.c"],
    }  # fmt: skip


def semantic(version: str) -> str:
    """A version as three numbers, which every ecosystem takes."""
    numbers = (re.findall(r"\d+", version) + ["0", "0", "0"])[:3]
    return ".".join(numbers)


def _cmake(name: str, texts: Mapping[str, str], names: Mapping[str, object]) -> Files:
    return {"CMakeLists.txt": render("packages/CMakeLists.txt.j2", **names), **_sources(name, texts)}


def _zephyr(name: str, texts: Mapping[str, str], names: Mapping[str, object]) -> Files:
    return {
        "zephyr/module.yml": render("packages/zephyr_module.yml.j2", **names),
        "zephyr/Kconfig": render("packages/zephyr_Kconfig.j2", **names),
        "zephyr/CMakeLists.txt": render("packages/zephyr_CMakeLists.txt.j2", **names), **_sources(name, texts),
    }  # fmt: skip


def _platformio(name: str, texts: Mapping[str, str], names: Mapping[str, object]) -> Files:
    return {
        "library.json": render("packages/library.json.j2", **names), f"src/{name}.c": texts[f"{name}.c"],
        f"include/{name}.h": texts[f"{name}.h"], "examples/selftest/selftest.c": texts["selftest.c"],
    }  # fmt: skip


def _arduino(name: str, texts: Mapping[str, str], names: Mapping[str, object]) -> Files:
    """Arduino compiles everything in src, and a sketch of its own calls the self-test there."""
    alone = f"/* The self-test without its main, which a sketch has no room for. */\n#define {name.upper()}_NO_MAIN\n\n"
    return {
        "library.properties": render("packages/library.properties.j2", **names), f"src/{name}.c": texts[f"{name}.c"],
        f"src/{name}.h": texts[f"{name}.h"], f"src/{name}_selftest.c": alone + texts["selftest.c"],
        f"examples/{name}_selftest/{name}_selftest.ino": render("packages/sketch.ino.j2", **names),
    }  # fmt: skip


def _sources(name: str, texts: Mapping[str, str]) -> Files:
    tests = {f"test/{file}": texts[file] for file in ("selftest.c", SELFTEST_HOOK) if file in texts}
    return {f"src/{name}.c": texts[f"{name}.c"], f"include/{name}.h": texts[f"{name}.h"], **tests}


KINDS: Final[Mapping[str, Callable[[str, Mapping[str, str], Mapping[str, object]], Files]]] = MappingProxyType(
    {"cmake": _cmake, "zephyr": _zephyr, "platformio": _platformio, "arduino": _arduino}
)
"""What lays out each kind."""


def bill_of_materials(record: Mapping[str, Any], files: Mapping[str, str]) -> str:
    """A CycloneDX 1.5 bill of materials: the library, its files with their hashes, what generated it. No time stands in it.

    Args:
        record: the folder's manifest.
        files: the files, by path.
    """
    reference = f"{record['name']}@{record['digest'][:16]}"
    made_by = [{"type": "application", "name": tool, "version": version} for tool, version in sorted(record["generator"].items())]
    bill = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "serialNumber": f"urn:uuid:{uuid.uuid5(_SERIALS, record['digest'])}",
        "version": 1,
        "metadata": {
            "tools": {"components": made_by},
            "component": {
                "type": "library", "bom-ref": reference, "name": record["name"], "version": record["digest"][:16],
                "description": "Equations of motion of a pendulum chain", "licenses": [{"license": {"name": "free for any use"}}],
            },
        },
        "components": [
            {"type": "file", "bom-ref": f"{reference}/{path}", "name": path, "hashes": [{"alg": "SHA-256", "content": _hash(text)}]}
            for path, text in sorted(files.items())
        ],
        "dependencies": [{"ref": reference, "dependsOn": [f"{reference}/{path}" for path in sorted(files)]}],
    }  # fmt: skip
    return json.dumps(bill, indent=2) + "\n"


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _manifest(record: Mapping[str, Any], kind: str, files: Mapping[str, str]) -> str:
    hashes = {path: f"sha256:{_hash(text)}" for path, text in sorted(files.items())}
    return json.dumps({**record, "package": kind, "files": hashes}, indent=2, ensure_ascii=True) + "\n"
