"""Numbers of the live page's pictures, by its own module in Node: envelopes in order of time, labels of time axes."""

import json
import subprocess
from typing import Any

import numpy as np
import pytest

from tests.by_hand.live_node import MODULES
from tests.by_hand.node import NODE, needs_node

_SCRIPT = """
import fs from 'fs';
const {module, calls} = JSON.parse(fs.readFileSync(0));
const figures = await import(module);
const answers = calls.map(([name, ...given]) => figures[name](...given));
process.stdout.write(JSON.stringify(answers, (_, value) => value instanceof Float64Array ? [...value] : value));
"""


def answers_of(*calls: list[Any]) -> list[Any]:
    """Answers of functions of the module, each called by its name and arguments."""
    told = {"module": (MODULES / "figures.mjs").resolve().as_uri(), "calls": calls}
    done = subprocess.run(
        [NODE or "", "--input-type=module", "--eval", _SCRIPT],
        input=json.dumps(told),
        capture_output=True,
        text=True,
        check=True,
    )
    answers: list[Any] = json.loads(done.stdout)
    return answers


@needs_node
@pytest.mark.defect("S600", before="each pixel lowest first: 900 rises in a signal that only falls", after="no rise")
def test_each_pixel_is_drawn_in_order_of_time() -> None:
    falling = [-float(n) for n in range(2501)]
    edge = [0.0] * 1000 + [1.0] * 501 + [0.0] * 1000
    down, up, pulse = answers_of(
        ["envelope", falling, 0, 2501, 900, 2e-5],
        ["envelope", falling[::-1], 0, 2501, 900, 2e-5],
        ["envelope", edge, 0, 2501, 300, 1.0],
    )
    assert np.all(np.diff(down["y"]) <= 0.0)
    assert np.all(np.diff(up["y"]) >= 0.0)
    assert down["x"] == up["x"], "two traces of one grid have the same abscissae"
    assert np.count_nonzero(np.diff(pulse["y"])) == 2, "one rise, one fall"
    at = np.array(pulse["x"])[1:][np.diff(pulse["y"]) != 0.0]
    assert at == pytest.approx([1000.0, 1501.0], abs=2501 / 300)


@needs_node
@pytest.mark.defect("S929", before="rows of a clock offset of 5 ms were drawn from 0", after="where they are")
def test_rows_of_a_late_clock_are_drawn_late() -> None:
    few, many = answers_of(
        ["envelope", [1.0, 2.0, 3.0], 1, 3, 10, 0.01, 0.005], ["envelope", [1.0] * 8, 0, 8, 2, 0.01, 0.005]
    )
    assert few["x"] == pytest.approx([0.015, 0.025])
    assert many["x"] == pytest.approx([0.005, 0.025, 0.045, 0.065])


@needs_node
@pytest.mark.defect("S601", before="0 0 0 0 0 0.001 for steps of 0.2 ms", after="0, 0.2 ms, 0.4 ms, ...")
@pytest.mark.parametrize(
    ("first", "step", "shown"),
    [
        (0.0, 2e-4, ["0", "0.2 ms", "0.4 ms", "0.6 ms", "0.8 ms", "1.0 ms"]),
        (0.0, 2.5e-7, ["0", "0.25 us", "0.50 us", "0.75 us", "1.00 us", "1.25 us"]),
        (0.0, 50.0, ["0", "50 s", "100 s", "150 s", "200 s", "250 s"]),
        (1.2345, 1e-6, ["1.234500 s", "1.234501 s", "1.234502 s", "1.234503 s", "1.234504 s", "1.234505 s"]),
        (-2e-3, 1e-3, ["−2 ms", "−1 ms", "0", "1 ms", "2 ms", "3 ms"]),
    ],
)
def test_labels_of_time_tell_neighbours_apart(first: float, step: float, shown: list[str]) -> None:
    (labels,) = answers_of(["timeLabels", [round(first + n * step, 15) for n in range(6)]])
    assert labels == shown


@needs_node
@pytest.mark.defect("S692", before="two rows of a held signal are a ramp that ends at the second", after="two steps")
def test_a_held_signal_is_drawn_as_steps_to_the_end_of_its_last_row() -> None:
    few, many = {"x": [0.0, 0.2], "y": [3.0, 5.0]}, {"x": [float(n) for n in range(301)], "y": [0.0] * 301}
    steps, flows, dense, none = answers_of(
        ["stepped", few, True, 0.2],
        ["stepped", few, False, 0.2],
        ["stepped", many, True, 1.0],
        ["stepped", {"x": [], "y": []}, True, 1.0],
    )
    assert (steps["x"], steps["y"]) == ([0.0, 0.2, 0.2, 0.4], [3.0, 3.0, 5.0, 5.0])
    assert flows == few
    assert dense == many
    assert none == {"x": [], "y": []}
