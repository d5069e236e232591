"""The whole path in a few lines: scene -> model -> programs -> texts -> folder -> compiled System."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import ceil
from pathlib import Path

from phichain.errors import OutputError, UnsupportedError
from phichain.files import write_folder
from phichain.firmware.drift import Drift, drift, edited_files
from phichain.laws import FamilyLaw, GainTable, Law, TrajectoryLaw
from phichain.native import ClosedLoop, build_files, default_cache, load_closed_loop, recalled, remember
from phichain.scene import Scene, given_scene
from phichain.scene.checks.validate import choice
from phichain.system import System


def generate(
    scene: Scene, out: Path | str = "generated", with_casadi_c: bool = False, prove: bool = True, force: bool = False,
    package: str | None = None,
) -> Path:
    """Write the standalone C and CasADi folder of a scene.

    Args:
        scene: what to generate.
        out: the folder in which NAME/ is written, whole or not at all.
        with_casadi_c: also write NAME_casadi.c for CasADi's ``external`` (double scenes only).
        prove: prove the Programs against the Lagrangian first; the manifest says which were proven, and how.
        force: overwrite files that were edited since they were generated.
        package: lay the folder out as a "cmake", "zephyr", "platformio" or "arduino" package, a CycloneDX bill of materials with it.

    Returns:
        The folder OUT/NAME.

    Raises:
        DerivationError: the Programs would not solve the derived Lagrangian.
        ProofError: a function does not meet the Lagrangian; nothing is written.
        OutputError: the folder cannot be written, or a file of it was edited; what was there before is still there.
        EmissionError: a number of the scene does not fit its type.
        UnsupportedError: there is no such package, or a function exceeds the target's limits.
    """
    folder = Path(out) / given_scene(scene).name
    edited = () if force else edited_files(folder)
    if edited:
        problem = f"was edited since it was generated ({', '.join(edited)})"
        raise OutputError("output", str(folder), problem, "keep your version elsewhere and generate with force (--force)")
    return write_folder(folder, _texts(scene, with_casadi_c, prove, package))


def _texts(scene: Scene, with_casadi_c: bool, prove: bool, package: str | None) -> Mapping[str, str]:
    """The files of a scene's folder, by path; arguments and errors as in `generate`."""
    from phichain.firmware.packages import known_kind, packaged

    if package is not None:
        known_kind(package)
    from phichain.scratch import folder_texts

    texts = folder_texts(scene, with_casadi_c, prove)
    return texts if package is None else packaged(package, texts)


def check_folder(
    scene: Scene, out: Path | str = "generated", with_casadi_c: bool = False, prove: bool = True, package: str | None = None
) -> Drift:
    """Compare OUT/NAME with what `generate` would write now, and write nothing.

    Args:
        scene: what was generated.
        out: the folder that holds NAME/.
        with_casadi_c: whether NAME_casadi.c belongs to it.
        prove: as when it was generated: the manifest says how each function was proven.
        package: which package it is.

    Raises:
        OutputError: the folder holds another scene, or cannot be read.
    """
    folder = Path(out) / given_scene(scene).name
    return drift(folder, _texts(scene, with_casadi_c, prove, package), scene.digest)


def generate_controller(law: Law, out: Path | str = "generated", real: str = "double") -> Path:
    """Write a controller as C that stands alone, with its self-test and its CasADi form.

    Args:
        law: what to generate, such as `lqr(system, s, sample=0.001).law(limit=20)`; one with an observer or integrals keeps its
            memory in a struct of its caller's, a table of gains has a supervisor.
        out: the folder in which NAME_controller/ is written, whole or not at all.
        real: "double" or "float", the type of the C.

    Returns:
        The folder OUT/NAME_controller.

    Raises:
        SceneError: there is no such type.
        OutputError: the folder cannot be written; what was there before is still there.
        EmissionError: a number of the law does not fit the type.
    """
    from phichain.emit.law import law_files

    texts = law_files(law, choice("real", real, ("double", "float")))
    return write_folder(Path(out) / f"{law.name}_controller", texts)


def generate_swingup(law: TrajectoryLaw, out: Path | str = "generated", real: str = "float") -> Path:
    """Write a law along a trajectory as C that stands alone, with its table and its self-test.

    Args:
        law: what to generate, such as `swing_up(system, limit=20, rail=1).law`.
        out: the folder in which NAME_swingup/ is written, whole or not at all.
        real: "float" or "double", the type of the C and of the table.

    Returns:
        The folder OUT/NAME_swingup.

    Raises:
        SceneError: there is no such type.
        OutputError: the folder cannot be written; what was there before is still there.
        EmissionError: a number of the law does not fit the type.
    """
    from phichain.emit.law.trajectory import swingup_files, swingup_name

    texts = swingup_files(law, choice("real", real, ("double", "float")))
    return write_folder(Path(out) / swingup_name(law), texts)


def generate_climb(law: FamilyLaw, out: Path | str = "generated", real: str = "float") -> Path:
    """Write a law along a family of orbits as C that stands alone, with its table and its self-test.

    Args:
        law: what to generate, such as `climb(scene, branch).climb.law`.
        out: the folder in which NAME_climb/ is written, whole or not at all.
        real: "float" or "double", the type of the C and of the table.

    Returns:
        The folder OUT/NAME_climb.

    Raises:
        SceneError: there is no such type.
        OutputError: the folder cannot be written; what was there before is still there.
        EmissionError: a number of the law does not fit the type.
    """
    from phichain.emit.law.climb import climb_files, climb_name

    texts = climb_files(law, choice("real", real, ("double", "float")))
    return write_folder(Path(out) / climb_name(law), texts)


def build(scene: Scene, prove: bool = True) -> System:
    """Derive, lower, prove, emit, compile and load a scene, or find all of that done and load it.

    What a proven build wrote is kept beside the compiled object, under the scene's digest and the generator that wrote it;
    both are checked before they are used.

    Args:
        scene: what to build.
        prove: prove the Programs against the Lagrangian, unless the cache holds that these were.

    Raises:
        SceneError: it is no scene.
        DerivationError: the Programs would not solve the derived Lagrangian.
        ProofError: a function does not meet the Lagrangian; nothing is compiled.
        CompilerError: the C compiler is missing, failed or hung.
        UnsupportedError: sines and cosines come from a function of the user's, which no library here has.
    """
    cache = default_cache()
    if given_scene(scene).trig == "hook":
        raise UnsupportedError(
            "target.trig", "hook", f"leaves sines and cosines to {scene.trig_hook}, which nothing can be linked with here",
            "generate the folder and link it with yours, or build the scene with another trig",
        )
    texts = recalled(scene, cache)
    if texts is None:
        from phichain.scratch import library_texts

        texts = library_texts(scene, prove, default_cache())
        system = build_files(texts)
        if prove:
            remember(scene, texts, cache)
        return system
    return build_files(texts)


def build_closed_loop(scene: Scene, table: GainTable, real: str = "double", longest: float = 1e-3) -> ClosedLoop:
    """Compile a chain together with the laws of a table, or find it compiled: what regions of attraction are counted with.

    The chain moves by its emitted `step` in double precision, the inputs held from one call of the law to the next.

    Args:
        scene: the chain, without runtime parameters.
        table: the laws; one without a period is called every `longest` seconds.
        real: "double" or "float", the type in which laws are computed.
        longest: longest step of the chain, s.

    Raises:
        SceneError: there is no such type.
        UnsupportedError: the scene has runtime parameters, or no `step`.
        CompilerError: the C compiler is missing, failed or hung.
    """
    from phichain.emit.law import closed_loop_files
    from phichain.scratch import library_texts

    chosen = choice("real", real, ("double", "float"))
    if scene.runtime:
        raise UnsupportedError("scene", scene.name, "has runtime parameters, which a closed loop does not take", "write their numbers into the scene")
    alone = replace(scene, real="double", want=("step",))
    texts, period = library_texts(alone, False), table.sample or longest
    kept = {file: texts[file] for file in (f"{scene.name}.h", f"{scene.name}.c")}
    loop, rows = closed_loop_files(replace(table, name=scene.name), chosen)
    return load_closed_loop(scene.name, kept | loop, len(table.state_names), (period, max(1, ceil(period / longest - 1e-9))), rows)
