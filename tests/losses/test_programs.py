"""Every function of a chain with losses: proven against the Lagrangian, and against the dense reference in 30 digits."""

from __future__ import annotations

from dataclasses import replace

import pytest
from mpmath import mp

from phichain.ir import evaluate
from phichain.lowering import lower_function
from phichain.mechanics import derive
from phichain.proof import prove
from phichain.reference import tangent_directions
from phichain.scene import Scene
from tests.losses.chains import kinds, label, offered
from tests.lowering.chains import gap, random_arguments
from tests.lowering.test_against_reference import agree, truth

CHAINS = list(kinds())
SPATIAL = [chain for chain in CHAINS if not chain.is_planar]
#: Only the dampers and dry friction of the forward dynamics, not digits, are looked at where masses are near the joints.
_DIGITS = 1e-12


@pytest.mark.long
@pytest.mark.parametrize("chain", CHAINS, ids=label)
def test_every_function_is_proven(chain: Scene) -> None:
    want = offered(chain, flows=True)
    made = prove(derive(replace(chain, want=want, variational="propagate" in want)))
    by_digits = {entry.name for entry in made.functions if not entry.is_exact}
    assert by_digits <= {
        "step_jacobian", "step_lie4", "step_variational", "step_rosenbrock", "propagate", "propagate_batch", "propagate_stiff",
        "forward_dynamics_batch", "constrained_accelerations",
    }  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("chain", CHAINS, ids=label)
def test_every_function_is_the_reference(chain: Scene) -> None:
    agree(chain, offered(chain))


@pytest.mark.long
@pytest.mark.parametrize("chain", SPATIAL, ids=label)
def test_spatial_jacobian_along_the_manifold(chain: Scene) -> None:
    program = lower_function(derive(chain), "state_jacobian", "loops")
    arguments = random_arguments(chain, program, seed=1)
    found, expected = evaluate(program, arguments), truth(chain, "state_jacobian", arguments)
    directions = tangent_directions(chain, arguments["q"], arguments["v"], digits=30)
    along = [
        found["dadq"] @ [float(mp.mpf(x)) for x in dq] + found["dadv"] @ [float(mp.mpf(x)) for x in dv] for dq, dv in directions
    ]
    assert gap(along, [[float(mp.mpf(x)) for x in row] for row in expected["tangent"]]) < _DIGITS
