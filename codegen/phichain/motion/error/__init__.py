"""How far a simulation can see: the estimated error of its state at every time, and until when it holds.

Local errors below a tolerance say nothing of what a motion makes of them: a chaotic one multiplies them a hundredfold and more
every few seconds, and the energy, which no error along the motion changes, does not show it. So every run is held against another:

- the Taylor flow of a compiled System against neighbours of low order that fly beside the steps it has left (`stencils/beside/neighbours.c`), when
  somebody asks;
- most other runs against a more accurate one, by the Taylor flow where the system has it, else by the method itself (`second`);
- the Taylor flow of a generated folder at round-off, where nothing is more accurate, against `neighbours` of its own path that are pushed as `rounding`
  pushes it, and show what that grows to.

`estimate` chooses, and says until when the run holds what it was asked.
"""

from phichain.motion.error.estimate import NONE, Estimate, estimated

__all__ = ["NONE", "Estimate", "estimated"]
