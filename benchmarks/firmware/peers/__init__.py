"""Others that compute the same forward dynamics on the same states: CasADi's own C, and a form written by hand."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Final

_HERE: Final = Path(__file__).parent
_HEADER: Final = "typedef float {name}_real;\nvoid {name}_forward_dynamics(const float *q, const float *v, const float *u, float *a);\n"


def expert(folder: Path, links: int, own_trigonometry: bool) -> Path:
    """The hand-written form, ready for the probe."""
    words = f"#define LINKS {links}\n" + ("#define OWN_SINCOS\n" if own_trigonometry else "")
    return _written(folder, "expert", links, words + (_HERE / "expert.c").read_text())


def casadi(folder: Path, links: int) -> Path:
    """What CasADi emits in single precision for the closed form with an L D L^T solve and common subexpressions shared."""
    import casadi as ca

    q, v, u = (ca.SX.sym(name, links) for name in "qvu")
    mass = length = 1 / links
    phi, omega = ca.cumsum(q), ca.cumsum(v)
    mu = [mass * length / 2 + length * mass * (links - 1 - k) for k in range(links)]
    m = ca.SX.zeros(links, links)
    b = [u[i] - (u[i + 1] if i + 1 < links else 0) - 9.81 * mu[i] * ca.sin(phi[i]) for i in range(links)]
    for i in range(links):
        for j in range(links):
            inertia = length * mu[max(i, j)]
            m[i, j] = inertia * ca.cos(phi[i] - phi[j]) if i != j else mass * length**2 / 4 + length**2 * mass * (links - 1 - i)
            if i != j:
                b[i] -= inertia * ca.sin(phi[i] - phi[j]) * omega[j] ** 2
    solved = _solved(m, b, links)
    a = ca.cse(ca.vertcat(solved[0], *(solved[k] - solved[k - 1] for k in range(1, links))))
    function = ca.Function("casadi_fd", [q, v, u], [a])
    generator = ca.CodeGenerator("casadi_fd.c", {"casadi_real": "float", "with_header": False})
    generator.add(function)
    text = generator.dump()
    call = (
        "\nvoid casadi_forward_dynamics(const float *q, const float *v, const float *u, float *a)\n{\n"
        "    const float *arg[3] = {q, v, u};\n    float *res[1] = {a};\n    casadi_fd(arg, res, 0, 0, 0);\n}\n"
    )
    return _written(folder, "casadi", links, text + call)


def _solved(m: Any, b: list[Any], links: int) -> list[Any]:
    for k in range(links):
        for i in range(k + 1, links):
            factor = m[i, k] / m[k, k]
            for j in range(k + 1, i + 1):
                m[i, j] -= factor * m[j, k]
            b[i] -= factor * b[k]
    for k in range(links - 1, -1, -1):
        for i in range(k + 1, links):
            b[k] -= m[i, k] * b[i]
        b[k] /= m[k, k]
    return b


def _written(folder: Path, name: str, links: int, text: str) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.h").write_text(_HEADER.format(name=name))
    (folder / f"{name}.c").write_text(text)
    vector = {"shape": [links], "doc": ""}
    row = {"params": False, "inputs": [{"name": one, **vector} for one in "qvu"], "outputs": [{"name": "a", **vector}]}
    (folder / "manifest.json").write_text(json.dumps({"name": name, "real": "float", "functions": {"forward_dynamics": row}}))
    return folder
