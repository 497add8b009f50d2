"""Claims about all sensors of a box."""

import math
from dataclasses import dataclass

from proofmass.runner.design.proof.closed_loop import GAIN, PHASE, Factor


@dataclass(frozen=True)
class Claim:
    """A claim about all sensors: a loop is stable with all factors between two ends at its wire."""

    loop: str
    open_at: str
    kind: str  # "stable", "gain margin" or "phase margin"
    limit: float  # dB or deg; 0 for "stable"

    @property
    def factor(self) -> Factor:
        """The factors at the wire."""
        return PHASE if self.kind == "phase margin" else GAIN

    @property
    def ends(self) -> tuple[float, float]:
        """The least and the largest factor; of a phase, negative ones follow from the positive ones."""
        if self.kind == "phase margin":
            return 0.0, math.nextafter(math.radians(self.limit), math.inf)
        if self.kind == "stable":
            return 1.0, 1.0
        factor = 10.0 ** (self.limit / 20.0) * (1.0 + 1e-15)
        return 1.0 / factor * (1.0 - 1e-15), factor

    @property
    def unit(self) -> str:
        """The unit of the limit."""
        return {"gain margin": "dB", "phase margin": "deg"}.get(self.kind, "")

    def __str__(self) -> str:
        """The claim in words."""
        return f"{self.kind} of at least {self.limit:g} {self.unit}" if self.unit else self.kind
