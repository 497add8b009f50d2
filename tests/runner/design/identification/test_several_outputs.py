"""Intervals of a fit to several outputs with few rows: each output against a fit of its own by NumPy."""

import numpy as np
import pytest
import scipy.special

from proofmass import Graph, fit
from proofmass.blocks import Constant, Gain

ROWS = 9
DRAWN = np.random.default_rng(8)
TIMES, SEEN = np.arange(ROWS) * 1e-3, DRAWN.standard_normal(ROWS)
LINE = 2.0 * SEEN + 0.3 + 0.1 * DRAWN.standard_normal(ROWS)
KNOWN = -SEEN + 0.01 * DRAWN.standard_normal((2, ROWS))
GRAPH = Graph(
    name="a scale and two references",
    rate="1 kHz",
    duration="9 ms",
    blocks={"seen": Constant(value=1.0), "scale": Gain(gain=1.0), "one": Gain(gain=-1.0), "two": Gain(gain=-1.0)},
    wires=[f"seen.output -> {name}.input" for name in ("scale", "one", "two")],
)


@pytest.mark.defect(
    "S1062", before="0.77 to 0.88 of intervals of 95 % held the truth, and noise was 0.82 of what it was", after="95 %"
)
def test_the_interval_of_an_unknown_is_that_of_the_output_that_tells_it() -> None:
    """Two unknowns of nine rows leave seven degrees of freedom, however many rows other outputs have."""
    outputs = {"scale.output": "line", "one.output": "first", "two.output": "second"}
    data = {"time": TIMES, "seen": SEEN, "line": LINE, "first": KNOWN[0], "second": KNOWN[1]}
    fitted = fit(
        GRAPH, data, inputs={"seen.output": "seen"}, outputs=outputs, free=["scale.gain"], offsets=["scale.output"]
    )
    table = np.stack([SEEN, np.ones(ROWS)], axis=1)
    best, (squares,), _, _ = np.linalg.lstsq(table, LINE)
    errors = np.sqrt(np.diag(np.linalg.inv(table.T @ table)) * squares / (ROWS - 2))
    assert [e.value for e in fitted.estimates] == pytest.approx(best, rel=1e-6)
    assert [e.standard_error for e in fitted.estimates] == pytest.approx(errors, rel=1e-6)
    widths = float(scipy.special.stdtrit(ROWS - 2, 0.975)) * errors
    assert [e.half_width for e in fitted.estimates] == pytest.approx(widths, rel=1e-6)
    noise = {output.signal: output.noise for output in fitted.outputs}
    assert noise["one.output"] == pytest.approx(np.sqrt(np.mean((KNOWN[0] + SEEN) ** 2)), rel=1e-6)


@pytest.mark.defect(
    "S1063", before="`g and h are correlated: +1.000` of gains in a row, whose product is known", after="none"
)
def test_what_is_not_determined_has_no_correlation() -> None:
    row = Graph(
        name="gains in a row",
        rate="1 kHz",
        duration="9 ms",
        blocks={"seen": Constant(value=1.0), "g": Gain(gain=1.0), "h": Gain(gain=1.0)},
        wires=["seen.output -> g.input", "g.output -> h.input"],
    )
    data = {"time": TIMES, "seen": SEEN, "line": LINE}
    inputs, outputs = {"seen.output": "seen"}, {"h.output": "line"}
    fitted = fit(row, data, inputs=inputs, outputs=outputs, free=["g.gain", "h.gain"])
    assert not fitted.determined
    assert fitted.as_data()["correlation"] == [[None, None], [None, None]]
    assert "correlated" not in str(fitted)
