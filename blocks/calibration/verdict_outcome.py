"""Outcome of a test: yield_loss = 1 for a good device that fails, test_escape = 1 for a bad one that passes, else 0.

Over a population their means are the two ways in which tests go wrong (Sarraf et al. 2012, section
1, after Deb and Blanton).
"""

from proofmass.blocks.declaration.declare import Block, Input


class VerdictOutcome(Block):
    """Compares the verdict of a test with the truth, which a simulation knows."""

    passes = Input("1", "Verdict of the test.", dtype=bool)
    good = Input("1", "Whether the device is good.", dtype=bool)


@VerdictOutcome.output("1")
def yield_loss(p: VerdictOutcome, passes: bool, good: bool) -> float:
    """1 where a good device fails."""
    return 1.0 if good and not passes else 0.0


@VerdictOutcome.output("1")
def test_escape(p: VerdictOutcome, passes: bool, good: bool) -> float:
    """1 where a bad device passes."""
    return 1.0 if passes and not good else 0.0
