"""Manifests of packages against what their ecosystems ask for, by the ecosystems' own validators where there are some.

Zephyr describes module.yml in scripts/zephyr_module.py (docs: "Module yaml file description"), Kconfig is what kconfiglib reads,
PlatformIO's own schema judges library.json, CycloneDX's the bill of materials. Arduino's linter is no package of a registry: where
`arduino-lint` is on the path it is asked, and in any case the library specification 1.5 to 2.2 holds, rule by rule.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, Final

from benchmarks.firmware.points.packages import product
from benchmarks.firmware.scenes import Generated
from phichain.files import write_folder
from phichain.firmware.packages import KINDS, packaged

_TEXT: Final = {"type": "string"}
_TEXTS: Final = {"type": "array", "items": _TEXT}
_FLAG: Final = {"type": "boolean"}
#: The keys of module.yml and their types.
_MODULE: Final[dict[str, Any]] = {
    "type": "object", "additionalProperties": False,
    "properties": {
        "name": _TEXT, "tests": _TEXTS, "samples": _TEXTS, "boards": _TEXTS, "blobs": {"type": "array"},
        "build": {
            "type": "object", "additionalProperties": False,
            "properties": {
                **{key: _TEXT for key in ("cmake", "kconfig", "sysbuild-cmake", "sysbuild-kconfig")}, "depends": _TEXTS,
                **{f"{key}-ext": _FLAG for key in ("cmake", "kconfig", "sysbuild-cmake", "sysbuild-kconfig")},
                "settings": {"type": "object", "additionalProperties": _TEXT},
            },
        },
    },
}  # fmt: skip
_CATEGORIES: Final = {
    "Display", "Communication", "Signal Input/Output", "Sensors", "Device Control", "Timing", "Data Storage", "Data Processing", "Other",
}  # fmt: skip
_REQUIRED: Final = ("name", "version", "author", "maintainer", "sentence", "paragraph", "category", "url", "architectures")
_KNOWN: Final = {*_REQUIRED, "email", "depends", "dot_a_linkage", "includes", "precompiled", "ldflags"}


def manifests(folders: Mapping[str, Generated]) -> Iterator[str]:
    """Packages: manifests by their ecosystems' own rules; bills of materials by CycloneDX's schema."""
    made = folders["fw_planar4_libm"]
    texts = product(made)
    for kind in KINDS:
        folder = write_folder(made.folder.parent / "manifests" / kind, packaged(kind, texts))
        yield from judged(kind, folder, made.scene.name)


def judged(kind: str, folder: Path, name: str) -> Iterator[str]:
    """What is wrong with a package of a kind."""
    judges: dict[str, Callable[[Path, str], Iterator[str]]] = {"zephyr": _zephyr, "platformio": _platformio, "arduino": _arduino}
    if kind in judges:
        yield from (f"{kind}: {fault}" for fault in judges[kind](folder, name))
    yield from (f"{kind}: {fault}" for fault in _bill((folder / f"{name}.cdx.json").read_text()))


def _zephyr(folder: Path, name: str) -> Iterator[str]:
    import jsonschema
    import kconfiglib
    import yaml

    module = yaml.safe_load((folder / "zephyr/module.yml").read_text())
    faults = [f"module.yml: {error.message}" for error in jsonschema.Draft202012Validator(_MODULE).iter_errors(module)]
    if faults:
        yield from faults
        return
    build = module.get("build", {})
    for path in (folder / build.get("cmake", "zephyr") / "CMakeLists.txt", folder / build.get("kconfig", "zephyr/Kconfig")):
        if not path.is_file():
            yield f"module.yml names {path.relative_to(folder)}, which is not there"
    try:
        kconfig = kconfiglib.Kconfig(str(folder / "zephyr/Kconfig"), warn_to_stderr=False)
    except kconfiglib.KconfigError as error:
        yield f"Kconfig: {error}"
        return
    yield from (f"Kconfig: {warning}" for warning in kconfig.warnings)
    upper = name.upper()
    symbols = {symbol.name for symbol in kconfig.unique_defined_syms}
    if symbols != {upper, f"{upper}_SELFTEST"}:
        yield f"Kconfig defines {sorted(symbols)}"
        return
    tested, chosen = kconfig.syms[f"{upper}_SELFTEST"], kconfig.syms[upper]
    before = tested.visibility
    chosen.set_value(2)
    if (before, tested.visibility, chosen.str_value) != (0, 2, "y"):
        yield "Kconfig: the self-test does not depend on the module"
    asked = set(re.findall(r"CONFIG_(\w+)", (folder / "zephyr/CMakeLists.txt").read_text()))
    if asked != symbols:
        yield f"CMakeLists.txt asks for {sorted(asked)}"


def _platformio(folder: Path, name: str) -> Iterator[str]:
    from platformio.package.exception import ManifestException
    from platformio.package.manifest.parser import ManifestParserFactory
    from platformio.package.manifest.schema import ManifestSchema

    library = json.loads((folder / "library.json").read_text())
    try:
        ManifestSchema().load_manifest(ManifestParserFactory.new_from_file(str(folder / "library.json")).as_dict())
    except ManifestException as error:
        yield f"library.json: {error}"
    for example in library.get("examples", []):
        yield from (f"no {path}" for path in example["files"] if not (folder / example["base"] / path).is_file())
    if not (folder / "include" / library["headers"]).is_file():
        yield f"no {library['headers']} in include"


def _arduino(folder: Path, name: str) -> Iterator[str]:
    lines = (folder / "library.properties").read_text().splitlines()
    properties = dict(line.split("=", 1) for line in lines if line and not line.startswith("#"))
    yield from (f"library.properties has no {key}" for key in _REQUIRED if not properties.get(key))
    yield from (f"library.properties knows no {key}" for key in properties if key not in _KNOWN)
    rules = {
        "name": r"[A-Za-z0-9][A-Za-z0-9 _.-]{0,62}", "version": r"\d+\.\d+\.\d+", "category": "|".join(map(re.escape, sorted(_CATEGORIES))),
        "url": r"https?://\S+", "architectures": r"\*|\w+(,\w+)*", "sentence": r"[^\n]{1,200}", "dot_a_linkage": "true|false",
    }  # fmt: skip
    for key, rule in rules.items():
        if key in properties and not re.fullmatch(rule, properties[key]):
            yield f"library.properties: {key}={properties[key]}"
    if properties.get("name", "").lower().startswith("arduino"):
        yield "library.properties: names that begin with Arduino are reserved"
    for header in properties.get("includes", "").split(","):
        if header and not (folder / "src" / header.strip()).is_file():
            yield f"no {header} in src"
    for sketch in (folder / "examples").rglob("*.ino"):
        if sketch.stem != sketch.parent.name:
            yield f"{sketch.name} stands in {sketch.parent.name}: a sketch has the name of its folder"
    if shutil.which("arduino-lint"):
        done = subprocess.run(["arduino-lint", "--library-manager", "false", folder], capture_output=True, text=True, check=False)
        if done.returncode:
            yield f"arduino-lint: {(done.stdout + done.stderr)[-600:]}"


def _bill(text: str) -> Iterator[str]:
    from cyclonedx.schema import SchemaVersion
    from cyclonedx.validation.json import JsonStrictValidator

    error = JsonStrictValidator(SchemaVersion.V1_5).validate_str(text)
    if error is not None:
        yield f"bill of materials: {str(error)[:400]}"
