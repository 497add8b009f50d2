"""Self-test verdict: trusted = settled and residual < limit; passes = trusted and inside.

A self-test answers yes or no (Sarraf et al. 2012, section 1). Of a calibration that did not settle,
or whose model does not answer as the device does (section 2.1, step vii), the parameters say
nothing: the device does not pass.
"""

from proofmass.blocks.declaration.declare import Block, Input, param


class SelfTestVerdict(Block):
    """Verdict of a self-test: passed or not, from a calibration of the device's reference model."""

    residual_limit: float = param(
        "V", "Largest residual of a model that agrees with its device: some noise.", default=8e-3, above=0.0
    )

    inside = Input("1", "Whether the identified parameters are within their tolerances.", dtype=bool)
    settled = Input("1", "Whether the calibration has settled.", dtype=bool)
    residual = Input("V", "Difference of the responses of device and model over the last period.")


@SelfTestVerdict.output("1")
def trusted(p: SelfTestVerdict, settled: bool, residual: float) -> bool:
    """True if the identified parameters can be trusted."""
    return settled and residual < p.residual_limit


@SelfTestVerdict.output("1")
def passes(p: SelfTestVerdict, inside: bool, settled: bool, residual: float) -> bool:
    """True if the device passes."""
    return inside and settled and residual < p.residual_limit
