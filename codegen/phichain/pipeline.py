"""The whole path in a few lines: scene -> model -> programs -> texts -> folder -> compiled System."""

from __future__ import annotations

from pathlib import Path

from phichain.files import write_folder
from phichain.laws import StateFeedback, TrajectoryLaw
from phichain.native import build_files, default_cache, recalled, remember
from phichain.scene import Scene, given_scene
from phichain.scene.validate import choice
from phichain.system import System


def generate(
    scene: Scene, out: Path | str = "generated", with_casadi_c: bool = False, prove: bool = True
) -> Path:
    """Write the standalone C and CasADi folder of a scene.

    Args:
        scene: what to generate.
        out: the folder in which NAME/ is written, whole or not at all.
        with_casadi_c: also write NAME_casadi.c for CasADi's ``external`` (double scenes only).
        prove: prove the Programs against the Lagrangian first; the manifest says which were proven, and how.

    Returns:
        The folder OUT/NAME.

    Raises:
        DerivationError: the Programs would not solve the derived Lagrangian.
        ProofError: a function does not meet the Lagrangian; nothing is written.
        OutputError: the folder cannot be written; what was there before is still there.
        EmissionError: a number of the scene does not fit its type.
    """
    from phichain.scratch import folder_texts

    texts = folder_texts(given_scene(scene), with_casadi_c, prove)
    return write_folder(Path(out) / scene.name, texts)


def generate_controller(law: StateFeedback, out: Path | str = "generated", real: str = "double") -> Path:
    """Write a controller as C that stands alone, with its self-test and its CasADi form.

    Args:
        law: what to generate, such as `lqr(system, s, sample=0.001).law(limit=20)`.
        out: the folder in which NAME_controller/ is written, whole or not at all.
        real: "double" or "float", the type of the C.

    Returns:
        The folder OUT/NAME_controller.

    Raises:
        SceneError: there is no such type.
        OutputError: the folder cannot be written; what was there before is still there.
        EmissionError: a number of the law does not fit the type.
    """
    from phichain.emit.law.controller import controller_files, controller_name

    texts = controller_files(law, choice("real", real, ("double", "float")))
    return write_folder(Path(out) / controller_name(law), texts)


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
    """
    cache = default_cache()
    texts = recalled(given_scene(scene), cache)
    if texts is None:
        from phichain.scratch import library_texts

        texts = library_texts(scene, prove, default_cache())
        system = build_files(texts)
        if prove:
            remember(scene, texts, cache)
        return system
    return build_files(texts)
