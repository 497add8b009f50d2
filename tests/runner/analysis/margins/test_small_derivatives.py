"""Derivatives by parameters at zero, which have no percent, are compared with what rounding leaves of them alone."""

import pytest

from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.runner.analysis.linearisation.linearisation import linearised
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.analysis.margins.sensitivity import transfer_sensitivities
from proofmass.runner.analysis.noise.budget import noise
from proofmass.runner.planning.plan import plan

SLIGHT = 1e-15  # V per Pa
PRESSED = f"""
name = "an offset that a pressure moves"
rate = "1 kHz"
samples = 10
wires = [
    "pressure.output -> slight.input", "hiss.output -> product.first", "level.output -> sum.first",
    "slight.output -> sum.second", "sum.output -> product.second", "input.output -> both.first",
    "sum.output -> both.second",
]
[blocks]
pressure = {{ kind = "Constant", value = 0, unit = "Pa" }}
slight = {{ kind = "Gain", gain = {SLIGHT}, input_unit = "Pa", output_unit = "V" }}
level = {{ kind = "Constant", value = 1, unit = "V" }}
sum = {{ kind = "Sum", unit = "V" }}
input = {{ kind = "Constant", value = 0, unit = "V" }}
both = {{ kind = "Sum", unit = "V" }}
hiss = {{ kind = "WhiteNoise", density = "0.5 V/sqrt(Hz)", unit = "V" }}
product = {{ kind = "Product", first_unit = "V", second_unit = "V" }}
"""


@pytest.mark.defect("S964", before="1e-15 V/Pa was dropped beside 1 V", after="compared with its own size")
def test_a_derivative_at_zero_is_kept_however_large_its_unit_is() -> None:
    planned = plan(read_graph_text(PRESSED))
    _, bias = transfer_sensitivities(
        linearised(planned), node_of(planned, "input.output"), node_of(planned, "both.output")
    )
    effects = {effect.parameter: effect.derivative for effect in bias.effects}
    assert effects["pressure.value"] == pytest.approx(SLIGHT, rel=1e-12)
    budget = noise(read_graph_text(PRESSED), "product.output", derivatives=True)
    assert budget.derivatives is not None
    by = {effect.parameter: effect.derivative for effect in budget.derivatives.effects}
    assert by["pressure.value"] == pytest.approx(SLIGHT * budget.rms, rel=1e-9)
