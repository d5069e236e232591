"""modelDescription.xml and buildDescription.xml of an FMU, the same bytes for the same scene."""

from __future__ import annotations

from typing import Final
from xml.etree import ElementTree as Xml

from phichain._version import __version__
from phichain.emit.fmu.variables import Variable, variables
from phichain.scene import Scene

_CAUSALITY: Final = {"time": "independent", "state": "output", "rate": "local", "input": "input", "parameter": "parameter", "energy": "output"}
_FACTORS: Final = {
    "s": {"s": "1"}, "m": {"m": "1"}, "m/s": {"m": "1", "s": "-1"}, "m/s2": {"m": "1", "s": "-2"}, "rad": {"rad": "1"},
    "rad/s": {"rad": "1", "s": "-1"}, "rad/s2": {"rad": "1", "s": "-2"}, "1/s": {"s": "-1"}, "kg": {"kg": "1"},
    "N": {"kg": "1", "m": "1", "s": "-2"}, "N.m": {"kg": "1", "m": "2", "s": "-2"}, "J": {"kg": "1", "m": "2", "s": "-2"},
    "kg.m2": {"kg": "1", "m": "2"}, "N.s/m": {"kg": "1", "s": "-1"}, "N.m.s/rad": {"kg": "1", "m": "2", "s": "-1", "rad": "-1"},
    "N.m/rad": {"kg": "1", "m": "2", "s": "-2", "rad": "-1"},
}  # fmt: skip
"""Exponents of the SI units of every unit."""
LICENSE: Final = "The C is generated and yours, without conditions."


def model_description(scene: Scene, has_flow: bool) -> str:
    """The description of a scene's variables and of what can be done with them.

    Args:
        scene: The scene.
        has_flow: Whether it can step by itself, for Co-Simulation.
    """
    found = variables(scene)
    root = Xml.Element(
        "fmiModelDescription", fmiVersion="3.0", modelName=scene.name, instantiationToken=token(scene), license=LICENSE,
        description=f"{scene.links} links, {scene.space}, {scene.base} base", generationTool=f"phichain {__version__}",
        variableNamingConvention="structured",
    )  # fmt: skip
    Xml.SubElement(root, "ModelExchange", modelIdentifier=scene.name, canGetAndSetFMUState="true")
    if has_flow:
        Xml.SubElement(root, "CoSimulation", modelIdentifier=scene.name, canGetAndSetFMUState="true", canHandleVariableCommunicationStepSize="true")
    units = Xml.SubElement(root, "UnitDefinitions")
    for unit in sorted({variable.unit for variable in found} - {""}):
        Xml.SubElement(Xml.SubElement(units, "Unit", name=unit), "BaseUnit", _FACTORS[unit])
    categories = Xml.SubElement(root, "LogCategories")
    Xml.SubElement(categories, "Category", name="logStatusError", description="why a call was refused")
    Xml.SubElement(root, "DefaultExperiment", startTime="0", stopTime="10", stepSize="0.01")
    described = Xml.SubElement(root, "ModelVariables")
    for variable in found:
        Xml.SubElement(described, "Float64", _attributes(variable))
    structure = Xml.SubElement(root, "ModelStructure")
    for variable in found:
        if _CAUSALITY[variable.role] == "output":
            Xml.SubElement(structure, "Output", valueReference=str(variable.reference))
    for variable in found:
        if variable.role == "rate":
            Xml.SubElement(structure, "ContinuousStateDerivative", valueReference=str(variable.reference))
    for variable in found:
        if variable.role in ("rate", "energy"):
            Xml.SubElement(structure, "InitialUnknown", valueReference=str(variable.reference))
    return _text(root)


def build_description(scene: Scene) -> str:
    """How the sources are compiled."""
    root = Xml.Element("fmiBuildDescription", fmiVersion="3.0")
    build = Xml.SubElement(root, "BuildConfiguration", modelIdentifier=scene.name)
    sources = Xml.SubElement(build, "SourceFileSet", language="C99")
    for name in (f"{scene.name}.c", "fmu.c"):
        Xml.SubElement(sources, "SourceFile", name=name)
    return _text(root)


def token(scene: Scene) -> str:
    """What an importer hands over so that description and binary are known to belong together: the scene's digest."""
    return "{" + "-".join((scene.digest[:8], scene.digest[8:12], scene.digest[12:16], scene.digest[16:20], scene.digest[20:32])) + "}"


def _attributes(variable: Variable) -> dict[str, str]:
    found = {"name": variable.name, "valueReference": str(variable.reference), "causality": _CAUSALITY[variable.role]}
    if variable.text:
        found["description"] = variable.text
    found["variability"] = "tunable" if variable.role == "parameter" else "continuous"
    if variable.role in ("state", "parameter"):
        found["initial"] = "exact"
    if variable.role in ("rate", "energy"):
        found["initial"] = "calculated"
    if variable.unit:
        found["unit"] = variable.unit
    if variable.rate_of:
        found["derivative"] = str(variable.rate_of)
    if variable.start is not None:
        found["start"] = repr(variable.start)
    return found


def _text(root: Xml.Element) -> str:
    Xml.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + Xml.tostring(root, encoding="unicode") + "\n"
