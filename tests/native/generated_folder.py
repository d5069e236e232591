"""A small generated folder written by hand, in the form the emitter writes.

The formulas are no pendulum: they are chosen so that every argument, parameter and output leaves its own
trace in the result, and `expected` repeats them in NumPy.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np

from phichain.scene import scene_from_dict

NAME = "duo"

HEADER = """\
#ifndef DUO_H
#define DUO_H
#define DUO_LINKS 2 /* number of links */
#define DUO_NQ 2
#define DUO_NV 2
#define DUO_NU 2
typedef REAL duo_real;
typedef struct {
    duo_real mass[2];
    duo_real gravity;
} duo_params;
void duo_forward_dynamics(const duo_params *p, const duo_real q[2], const duo_real v[2],
                          const duo_real u[2], duo_real a[2]);
void duo_mass_matrix(const duo_params *p, const duo_real q[2], duo_real out[4]);
void duo_energy(const duo_params *p, const duo_real q[2], const duo_real v[2],
                duo_real *kinetic, duo_real *potential);
void duo_step(const duo_params *p, duo_real h, const duo_real q[2], const duo_real v[2], const duo_real u[2],
              duo_real q_next[2], duo_real v_next[2]);
void duo_linearization(const duo_real s[2], duo_real M[4], duo_real G[4], duo_real B[4]);
#endif
"""

SOURCE = """\
#include <math.h>
#include "duo.h"

void duo_forward_dynamics(const duo_params *p, const duo_real *q, const duo_real *v,
                          const duo_real *u, duo_real *a)
{
    a[0] = u[0] / p->mass[0] - p->gravity * q[0] + v[1];
    a[1] = u[1] / p->mass[1] - p->gravity * q[1] + sqrtSUFFIX(v[0] * v[0]);
}

void duo_mass_matrix(const duo_params *p, const duo_real *q, duo_real *out)
{
    out[0] = p->mass[0];
    out[1] = q[0];
    out[2] = q[1];
    out[3] = p->mass[1];
}

void duo_energy(const duo_params *p, const duo_real *q, const duo_real *v,
                duo_real *kinetic, duo_real *potential)
{
    *kinetic = p->mass[0] * v[0] * v[0] + p->mass[1] * v[1] * v[1];
    *potential = p->gravity * (q[0] - q[1]);
}

void duo_step(const duo_params *p, duo_real h, const duo_real *q, const duo_real *v, const duo_real *u,
              duo_real *q_next, duo_real *v_next)
{
    int k;
    for (k = 0; k < 2; k++) {
        q_next[k] = q[k] + h * v[k];
        v_next[k] = v[k] + h * u[k] / p->mass[k];
    }
}

void duo_linearization(const duo_real *s, duo_real *M, duo_real *G, duo_real *B)
{
    M[0] = s[0];
    M[1] = M[2] = 0;
    M[3] = s[1];
    G[0] = 2 * s[0];
    G[1] = G[2] = 0;
    G[3] = 2 * s[1];
    B[0] = B[3] = 1;
    B[1] = B[2] = 0;
}
"""

CASADI_PY = """\
import casadi

def forward_dynamics():
    q, v, u = (casadi.SX.sym(name, 2) for name in ("q", "v", "u"))
    p = casadi.SX.sym("p", 3)
    a = u / p[:2] - p[2] * q + casadi.vertcat(v[1], casadi.fabs(v[0]))
    return casadi.Function("forward_dynamics", [p, q, v, u], [a], ["p", "q", "v", "u"], ["a"])
"""

Q, V, U, A = ({"name": name, "shape": [2]} for name in ("q", "v", "u", "a"))

FUNCTIONS: dict[str, Any] = {
    "forward_dynamics": {"params": True, "inputs": [Q, V, U], "outputs": [A]},
    "mass_matrix": {"params": True, "inputs": [Q], "outputs": [{"name": "out", "shape": [2, 2]}]},
    "energy": {
        "params": True,
        "inputs": [Q, V],
        "outputs": [{"name": "kinetic", "shape": []}, {"name": "potential", "shape": []}],
    },
    "step": {
        "params": True,
        "inputs": [{"name": "h", "shape": []}, Q, V, U],
        "outputs": [{"name": "q_next", "shape": [2]}, {"name": "v_next", "shape": [2]}],
    },
    "linearization": {
        "params": False,
        "inputs": [{"name": "s", "shape": [2]}],
        "outputs": [{"name": name, "shape": [2, 2]} for name in ("M", "G", "B")],
    },
}

SCENE = {
    "name": NAME,
    "chain": {
        "links": 2,
        "space": "planar",
        "base": "fixed",
        "mass": "runtime",
        "length": 0.5,
        "gravity": "runtime",
    },
    "joints": {"actuated": "all"},
    "functions": {"want": sorted(FUNCTIONS)},
}

PARAMETERS = {"mass": [2.0, 4.0], "gravity": 9.0}


def write(parent: Path, real: str = "double", source: str = SOURCE, **files: str) -> Path:
    """Write the folder ``parent/duo``; keywords are further files, with ``__`` for the dot."""
    texts = {
        "duo.h": HEADER.replace("REAL", real),
        "duo.c": source.replace("SUFFIX", "f" if real == "float" else ""),
        "duo_casadi.py": CASADI_PY,
        **{name.replace("__", "."): text for name, text in files.items()},
    }
    functions = {
        name: {"symbol": f"{NAME}_{name}", "code": "unrolled", "operations": {}, **entry}
        for name, entry in FUNCTIONS.items()
    }
    scene = scene_from_dict({**SCENE, "target": {"real": real}})
    manifest = {
        "name": NAME,
        "scene": scene.to_dict(),
        "digest": scene.digest,
        "real": real,
        "params": [{"name": "mass", "shape": [2]}, {"name": "gravity", "shape": []}],
        "functions": functions,
        "files": {
            name: f"sha256:{hashlib.sha256(text.encode()).hexdigest()}" for name, text in texts.items()
        },
        "left_out": {},
    }
    folder = parent / NAME
    folder.mkdir(parents=True)
    for name, text in {**texts, "manifest.json": json.dumps(manifest)}.items():
        (folder / name).write_text(text)
    return folder


def expected(q: np.ndarray, v: np.ndarray, u: np.ndarray, h: float | np.ndarray = 0.0) -> dict[str, Any]:
    """What the functions return at PARAMETERS for rows (n, 2) or single states (2,)."""
    mass, gravity = np.array(PARAMETERS["mass"]), PARAMETERS["gravity"]
    turned = np.stack([v[..., 1], np.abs(v[..., 0])], axis=-1)
    step = np.asarray(h)[..., None]
    matrix = np.empty((*q.shape[:-1], 2, 2))
    matrix[..., 0, 0], matrix[..., 1, 1] = mass
    matrix[..., 0, 1], matrix[..., 1, 0] = q[..., 0], q[..., 1]
    return {
        "forward_dynamics": u / mass - gravity * q + turned,
        "mass_matrix": matrix,
        "energy": ((mass * v**2).sum(-1), gravity * (q[..., 0] - q[..., 1])),
        "step": (q + step * v, v + step * u / mass),
    }
