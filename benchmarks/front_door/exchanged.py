"""An FMU beside `simulate`: co-simulation at every output, and what validators say."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks.table import Table
from phichain import Scene, build, simulate
from phichain.errors import PhichainError
from phichain.exchange import write_fmu

SCENES = (
    Scene("fmu_planar", 2, mass=[1.0, 0.7], length=0.5, want=("forward_dynamics", "energy", "propagate")),
    Scene("fmu_cart", 3, base="cart", cart_mass=2.0, mass=0.4, length=0.3, damping=0.01, want=("forward_dynamics", "propagate")),
    Scene("fmu_long", 8, mass=0.125, length=0.125, com=0.0625, actuated="none", want=("forward_dynamics", "propagate")),
)


def table(scratch: Path) -> Table:
    """Each scene's FMU for two seconds, at FMPy's hands."""
    try:
        import fmpy
        from fmpy.validation import validate_fmu
    except ImportError:
        return Table("Exchange", ("what", "measured", "reach"), (("FMUs", "skipped: fmpy is not installed: pip install 'phichain[dev]'", "-"),))
    rows = []
    for scene in SCENES:
        try:
            path = str(write_fmu(scene, scratch / f"{scene.name}.fmu"))
        except PhichainError as failure:
            rows.append((f"FMU of {scene.name}", str(failure), "1e-10"))
            continue
        angles = [name for name in scene.q_names if name.startswith("theta")]
        starts = dict.fromkeys(angles, 0.4 / scene.links)
        result = fmpy.simulate_fmu(path, stop_time=2.0, output_interval=0.05, fmi_type="CoSimulation", start_values=starts, relative_tolerance=1e-12)
        q = np.array([starts.get(name, 0.0) for name in scene.q_names])
        motion = simulate(build(scene), (q, np.zeros(scene.nv)), np.linspace(0.0, 2.0, 41), tol=1e-12)
        names = (*scene.q_names, *scene.v_names)
        apart = max(float(np.abs(result[name] - column).max()) for name, column in zip(names, motion.x.T, strict=True))
        problems = validate_fmu(path)
        rows.append((f"FMU of {scene.links} links, {scene.base} base: apart from `simulate`", f"{apart:.1e}", "1e-10"))
        rows.append(("what FMPy's validation finds wrong with it", f"{len(problems)} problems" if problems else "nothing", "passes"))
    return Table("Exchange", ("what", "measured", "reach"), tuple(rows), ("FMI 3.0, co-simulation for 2 s at 1e-12 from a bent chain that swings gently, as chaos would be measured otherwise; the largest difference of an angle, place or rate.",))
