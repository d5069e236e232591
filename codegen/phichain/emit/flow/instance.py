"""One instance of the Taylor flow's stencils: what of a scene they take, and the Programs they call, printed."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from phichain.contract.flow import Flow
from phichain.emit.c.comment import Comments
from phichain.emit.c.function import c_function
from phichain.emit.c.lanes import lane_declaration, lane_function
from phichain.emit.c.names import CNames
from phichain.emit.c.parts import declaration, words
from phichain.emit.flow.binary import binary_numbers, binary_words
from phichain.emit.flow.declared import arguments, passed_on
from phichain.ir.nodes import Program
from phichain.ir.rounded import nearest
from phichain.lowering.lower import lower_function
from phichain.lowering.rates import fastest_rate, reach, weight_rate
from phichain.lowering.series.series import HIGHEST, LOST, NEWEST, Series
from phichain.lowering.series.spatial.ends import spatial_ends
from phichain.mechanics import Model
from phichain.scene import Scene

#: Tolerances below this are round-off.
EPSILON: Final = {"double": Fraction(1, 2**52), "float": Fraction(1, 2**23)}
#: Difference of the slopes at a step's end that passes, in units of the local error aimed at. The term behind the last
#: enters the slope times the order: some ten of these are common.
ROOM: Final = 64
#: Relative differences below this may be rounding of the equations themselves.
NOISE: Final = {"double": Fraction(1, 2**26), "float": Fraction(1, 2**12)}
#: Binary logarithm of the longest step, in seconds.
HUGE: Final = {"double": 700, "float": 80}
#: Entries of left rows up to which it is worth leaving out the products of the newest rows that are zero: longer ones are vectors,
#: whose loops then take up more than the products.
FEW: Final = 6
#: log 2 to 40 digits.
LOG_TWO: Final = Fraction(6931471805599453094172321214581765680755, 10**40)
#: 2 pi to twice the precision.
TURN: Final = Fraction(6283185307179586476925286766559005768394338798750, 10**48)

Tables = dict[tuple[str, tuple[Fraction, ...]], str]


@dataclass(frozen=True)
class Called:
    """A Program that the stencils call.

    Attributes:
        symbol: its name in C.
        program: the Program.
        lanes: the stem of the vectors it runs on; empty for numbers.
        uniform: arguments that are one number for all lanes.
        takes_params: whether it is given the runtime parameters where the scene has some.
    """

    symbol: str
    program: Program
    lanes: str = ""
    uniform: frozenset[str] = frozenset()
    takes_params: bool = True


@dataclass(frozen=True)
class Part:
    """One static function as the template sees it."""

    comment: tuple[str, ...]
    symbol: str
    definition: str
    ignored: tuple[str, ...]
    lines: tuple[str, ...]


def c_names(scene: Scene, stem: str, programs: Iterable[Program]) -> CNames:
    """The spelling of a scene's C, with the tables of these Programs."""
    tables: Tables = {}
    for program in programs:
        for key in program.tables.items():
            tables.setdefault(key, f"{stem}_{key[0]}_{len(tables) + 1}")
    return CNames(scene.name, scene.real, tables, is_plain=scene.trig is not None)


def table_rows(names: CNames) -> list[tuple[str, int, str]]:
    """Name, size and numbers of every table, for a template."""
    return [
        (table, len(values), ", ".join(names.number(value).text for value in values))
        for (_, values), table in names.tables.items()
    ]


def on_numbers(scene: Scene, program: Program) -> list[str]:
    """The arguments of a Program on numbers, as a static function declares them."""
    declared = [declaration(array, scene.name, False, True) for array in program.inputs]
    return declared + [declaration(array, scene.name, True, True) for array in program.outputs]


def static_function(
    scene: Scene, comments: Comments, called: Called, declared: list[str], lines: tuple[str, ...]
) -> Part:
    """A printed Program as the template sees it; what its body does not use is said to be ignored."""
    program, given = called.program, [array.name for array in called.program.inputs]
    if scene.runtime and called.takes_params:
        declared, given = [f"const {scene.name}_params *p", *declared], ["p", *given]
    used = words("\n".join(lines))
    ignored = tuple(name for name in given if name not in used)
    comment = comments.above(program.name, program.doc, lines)
    return Part(comment, called.symbol, ", ".join(declared), ignored, lines)


def printed(scene: Scene, names: CNames, called: Iterable[Called]) -> tuple[list[Part], frozenset[str]]:
    """The Programs as static functions, and the kernels that they lean on."""
    comments, parts, uses = Comments(scene), [], {"math", *(("sincos",) if own_trigonometry(scene) else ())}
    for one in called:
        program = one.program
        if one.lanes:
            body = lane_function(program, names, one.lanes, one.uniform)
            declared = [
                lane_declaration(array, scene.name, one.lanes, is_output, array.name in one.uniform)
                for is_output, arrays in ((False, program.inputs), (True, program.outputs))
                for array in arrays
            ]
        else:
            body, declared = c_function(program, names, {}), on_numbers(scene, program)
        parts.append(static_function(scene, comments, one, declared, body.lines))
        uses |= body.uses
    return parts, frozenset(uses)


def turns(scene: Scene) -> bool:
    """Whether all forces repeat every turn of an angle: springs do not."""
    return scene.is_planar and scene.stiffness is None


def shares(scene: Scene, lanes: bool) -> bool:
    """Whether trajectories, side by side where `lanes`, keep every number once: in space."""
    return lanes and not scene.is_planar


def at_once(made: Series, lanes: bool = False) -> Program | None:
    """All orders at once, where there is such a Program; with derivatives it writes rows that trajectories side by side have no use for."""
    return None if lanes and made.columns is not None else made.outright


def steps_stencils(scene: Scene, made: Series, lanes: bool = False) -> list[str]:
    """The stencils of a step, in the order in which they lean on each other; `lanes`: of trajectories side by side."""
    winds = turns(scene)
    return [
        "flow/norms", *(["flow/fused"] if winds or made.is_forced else []), *(["flow/turns"] if winds else []),
        *(["flow/drive"] if made.is_forced else []), *(["flow/rubs"] if made.rubs else []),
        *(["flow/shared_sums", "flow/shared"] if shares(scene, lanes) else ["flow/series"] if at_once(made, lanes) is not None else ["flow/sums", "flow/series"]),
        "flow/move",
    ]  # fmt: skip


def own_trigonometry(scene: Scene) -> bool:
    """Whether a forcing's phase goes through the scene's own sines and cosines, as the angles do, and not through the C library."""
    return scene.forced is not None and scene.trig in ("bundled", "hook")


def cart(scene: Scene) -> int:
    """Coordinates of the cart."""
    return (1 if scene.is_planar else 2) if scene.has_cart else 0


def sizes(scene: Scene, stem: str, made: Series, names: CNames) -> dict[str, object]:
    """What the template of an instance's constants wants to know."""
    rows = [
        (Fraction(n + 1), Fraction(1, n + 1), Fraction(1, (n + 1) * (n + 2)), Fraction(int(n == 0)))
        for n in range(HIGHEST[scene.real])
    ]
    return {
        "stem": stem, "nq": scene.nq, "nu": scene.nu, "cart": cart(scene), "masses": scene.links,
        "axes": 2 if scene.is_planar else 3, "lefts": made.lanes, "rights": made.rights, "squares": made.squares, "dry": made.dry, "rubs": made.rubs, "left_width": made.width, "all": made.sums, "row": 0,
        "highest": HIGHEST[scene.real], "held": made.held, "forced": made.is_forced, "varied": sum(scene.varied.values()), "turns": turns(scene), "real": f"{scene.name}_real",
        "abs": names.libm("fabs"), "now": [", ".join(names.number(value).text for value in row) for row in rows],
        "tables": table_rows(names),
    }  # fmt: skip


def features(scene: Scene, made: Series, columns: bool, lanes: bool = False) -> dict[str, bool]:
    """Which features of the stencils a scene has, with columns of derivatives or with trajectories side by side."""
    return {
        "WITH_TURNS": turns(scene), "WITH_SPRINGS": scene.stiffness is not None, "WITH_SPHERE": not scene.is_planar, "WITH_INPUTS": scene.nu > 0, "WITH_FORCING": made.is_forced,
        "WITH_OWN_TRIGONOMETRY": own_trigonometry(scene),
        "WITH_SQUARES": made.squares > 0, "WITH_DRY": made.dry > 0, "WITH_RUBS": made.rubs > 0, "WITH_SCALES": scale_literals(scene, None) is not None,
        "WITH_LOST": _takes(made.factor, LOST), "WITH_COLUMNS": columns, "WITH_PARAMETERS": columns and made.order_along is not None,
        "WITH_ANGLES": not lanes and made.by_links and made.lanes <= FEW, "WITH_LINKS": columns and made.by_links, "WITH_SHARED": shares(scene, lanes), "WITH_OUTRIGHT": at_once(made, lanes) is not None, "WITH_CROSSED": made.rights > 1, "WITH_BESIDE": False, "WITH_PAIRS": False,
    }  # fmt: skip


def spelling(model: Model, made: Series, stem: str, contract: Flow, names: CNames, positions: str) -> dict[str, str]:
    """What stands for the stencils' names.

    Args:
        model: the scene's mechanics.
        made: its recurrences.
        stem: prefix of everything that belongs to this instance.
        contract: the flow's arguments.
        names: spelling of numbers.
        positions: the function that gives the masses' positions.
    """
    scene, real = model.scene, model.scene.real
    has_params = bool(scene.runtime)
    of_positions = bool(lower_function(model, "positions", "loops").params)
    high = Fraction(nearest(real, TURN))
    parameter = f"const {scene.name}_params *p, "
    numbers = {
        "PHI_HALF": Fraction(1, 2), "PHI_EPSILON": EPSILON[real], "PHI_NOISE": NOISE[real], "PHI_TURN_HIGH": high,
        "PHI_TURN_LOW": TURN - high, **binary_numbers(real),
    }  # fmt: skip
    return {
        "PASS": "p, " if has_params else "", "CONTEXT": parameter if has_params else "",
        "POSITIONS_PASS": "p, " if of_positions else "", "POSITIONS_CONTEXT": parameter if of_positions else "",
        "ARGUMENTS": ", ".join(arguments(contract, scene, definition=True)), "PASS_ALL": passed_on(contract, scene),
        "INPUTS": "jet->u, " if scene.nu else "", "INPUTS_OF_ALL": f"const {scene.name}_real u[], " if scene.nu else "",
        "FORCE": "given" if made.is_forced else "", "AFTER": "given" if made.is_forced else "",
        "BEHIND": "later" if made.is_forced else "held", "PASS_FORCING": "amplitude, omega, " if made.is_forced else "",
        "FORCING_OF_ALL": "".join(f"const {scene.name}_real {name}[], " for name in ("amplitude", "omega")) if made.is_forced else "",
        "NEWEST": "given" if _takes(made.order, NEWEST) else "", "LOST": "lost, " if _takes(made.factor, LOST) else "", "PASS_INPUTS": "u, " if scene.nu else "", "PHI_ROOM": str(ROOM), "PHI_HUGE": str(HUGE[real]), **binary_words(real),
        **{name: names.number(value).text for name, value in numbers.items()},
        "PHI_SCALES": ", ".join(scale_literals(scene, names) or ()), **_scale_words(scene), "phi_positions": positions,
        **libm_names(names), "phi_": f"{scene.name}_", "PHI_": f"{scene.name.upper()}_",
        "STEM_ZERO": f"{stem.upper()}_EVERY(0)", "stem_": f"{stem}_", "STEM_": f"{stem.upper()}_",
    }  # fmt: skip


def _takes(program: Program, name: str) -> bool:
    return any(array.name == name for array in program.inputs)


def scale_literals(scene: Scene, names: CNames | None) -> tuple[str, ...] | None:
    """Fastest linear rate, length of the chain and, with springs, the rate that weight gives, as literals; None where they are computed."""
    rate, length = fastest_rate(scene), reach(scene)
    if rate is None or length is None:
        return None
    scales = [rate, length] if scene.stiffness is None else [rate, length, weight_rate(scene)]
    return tuple("" if names is None else names.number(value).text for value in scales)


def _scale_words(scene: Scene) -> dict[str, str]:
    """How many scales there are, what they are, and which one makes rates of angles that no spring holds."""
    words = "fastest linear rate, length of the chain"
    if scene.stiffness is None:
        return {"PHI_SCALE_COUNT": "2", "PHI_SCALE_WORDS": words, "PHI_WEIGHT_SCALE": "0"}
    return {"PHI_SCALE_COUNT": "3", "PHI_SCALE_WORDS": f"{words}, rate that weight gives", "PHI_WEIGHT_SCALE": "2"}


def libm_names(names: CNames) -> Mapping[str, str]:
    """The C library's functions as the stencils call them, for the scene's type."""
    functions = {"abs": "fabs", "fma": "fma", "cos": "cos", "sin": "sin"}
    fast = "F" if names.real == "float" else ""
    return {f"phi_{key}": names.libm(function) for key, function in functions.items()} | {
        "PHI_FAST_FMA": f"FP_FAST_FMA{fast}", "PHI_FMA_OF_GCC": f"__FP_FAST_FMA{fast}"
    }  # fmt: skip


def positions_symbol(model: Model, stem: str, known: Collection[str]) -> tuple[str, list[Called]]:
    """The function that gives the masses' positions, and its Program where the scene has none of its own."""
    if "positions" in known:
        return f"{model.scene.name}_positions", []
    symbol = f"{stem}_positions"
    program = lower_function(model, "positions", "loops")
    return symbol, [Called(symbol, program, takes_params=bool(program.params))]


def ends_of_a_call(scene: Scene, stem: str, lanes: str = "", columns: bool = False) -> list[Called]:
    """The Programs that lead into a spatial flow and out of it again; none in the plane."""
    if scene.is_planar:
        return []
    ends = spatial_ends(scene)
    called = [
        Called(f"{stem}_enter", ends.enter, takes_params=False), Called(f"{stem}_leave", ends.leave, takes_params=False),
        Called(f"{stem}_settle", ends.settle, lanes, takes_params=False),
    ]  # fmt: skip
    if columns:
        called += [
            Called(f"{stem}_enter_column", ends.enter_column, takes_params=False),
            Called(f"{stem}_leave_column", ends.leave_column, takes_params=False),
        ]
    return called
