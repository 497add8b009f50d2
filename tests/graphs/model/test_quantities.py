"""Quantities as messages, tables and pictures name them."""

import pytest

from proofmass.graphs.model.quantities import MeasureOf, Noise, Quantity, ResponseFigure, TransferPart, YieldOf


@pytest.mark.parametrize(
    ("quantity", "name"),
    [
        (TransferPart("scale_factor", "adc.number", "push.output", "V"), "scale factor from push.output to adc.number"),
        (ResponseFigure("gain", "a.output", "b.output", 50.0, "1"), "gain from b.output to a.output at 50 Hz"),
        (ResponseFigure("bandwidth", "a.output", "b.output", None, "Hz"), "bandwidth from b.output to a.output"),
        (MeasureOf("offset", "V"), "measure offset"),
        (Noise("adc.number", "", None, "1"), "noise of adc.number"),
        (Noise("adc.number", "push.output", (0.5, 100.0), "N"), "noise of adc.number at push.output, 0.5 Hz to 100 Hz"),
        (YieldOf("offset"), "yield of offset"),
        (YieldOf(""), "yield"),
    ],
)
def test_a_quantity_has_a_name(quantity: Quantity, name: str) -> None:
    assert str(quantity) == name
