"""The PN self-test, run and judged: the impulse response from the correlation cells beside the analytic one.

    python -m benchmarks.self_test [OUT]

Analytic: the device held over a chip and sampled at the chips, y = C x, has h[k] = C A^(k-1) B (A, B by SciPy's matrix
exponential). Correlated with a maximal-length sequence of N chips the sums are (N+1) h[k] - sum of h: the second term
is the constant that the autocorrelation of -1 beside the peak leaves in every cell (Sarraf et al. 2012, eq. 2 and 3).
"""

import sys
from html import escape
from importlib.resources import as_file
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.graph import Graph
from proofmass.runner.commands.answers import DONE, WRONG_MODEL
from proofmass.runner.commands.progress import progress
from proofmass.runner.commands.run_files import write_run
from proofmass.runner.commands.run_text import show_run
from proofmass.runner.output.page import picture
from proofmass.runner.output.pictures import BLUE, GRID, ORANGE, save_figure, sheet
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import simulate

GRAPH = "pn_self_test_accelerometer.toml"
CELLS = "correlator.impulse_response"


class CellSums(NamedTuple):
    """Cell by cell: sums of the run and sums by the analytic response, in codes."""

    measured: Any
    analytic: Any
    constant: float  # the part of every sum that is minus the sum of the response

    @property
    def error(self) -> Any:
        """Relative error of each cell."""
        return self.measured / self.analytic - 1.0


def judge(result: Result) -> CellSums:
    """Mean of the sums of all periods after the first against the analytic response of the same graph."""
    sums = result[CELLS].values
    if len(sums) < 3:
        raise ValueError("needs at least two whole periods: the first one holds the transient of the start")
    response = analytic_response(result.graph)
    chips = result.graph.blocks["correlator"].chips  # type: ignore[attr-defined]
    measured = sums[2:].mean(axis=0)
    return CellSums(
        measured=measured,
        analytic=(chips + 1) * response[: sums.shape[1]] - response.sum(),
        constant=-float(response.sum()),
    )


def analytic_response(graph: Graph, cells: int = 1023) -> Any:
    """Codes at the output, per chip of the sequence, k chips after it."""
    # start-up time: this part of SciPy takes 0.15 s
    from scipy.linalg import expm

    p: Any = graph.blocks
    device = p["accelerometer"]
    stiffness, damping = device.stiffness / device.mass, device.damping / device.mass
    joined = np.array([[0.0, 1.0, 0.0], [-stiffness, -damping, 1.0 / device.mass], [0.0, 0.0, 0.0]])
    held = expm(joined / float(graph.rate or 1))
    a, x = held[:2, :2], held[:2, 2]
    force = 2.0 * p["comb"].capacitance_gradient * p["comb"].bias * p["dac"].level
    codes = p["readout"].gain * 2.0 ** (p["adc"].bits - 1) / p["adc"].reference
    response = [0.0]
    for _ in range(cells - 1):
        response.append(float(x[0]) * force * codes)
        x = a @ x
    return np.array(response)


def table(verdict: CellSums, finer: CellSums) -> list[str]:
    """The verdict as lines of text; `finer` is that of the same graph with a converter of 32 bits."""
    lines = [f"{'cell':>4} {'estimated':>14} {'analytic':>14} {'error':>10}"]
    for k, (measured, analytic, error) in enumerate(
        zip(verdict.measured, verdict.analytic, verdict.error, strict=True)
    ):
        lines.append(f"{k:4} {measured:14,.1f} {analytic:14,.1f} {100 * error:9.4f} %")
    worst, finest = (float(np.abs(v.measured - v.analytic).max()) for v in (verdict, finer))
    lines += [
        f"Sums in codes. {verdict.constant:,.0f} in each is the -1 of the autocorrelation times the whole response.",
        f"The largest difference is {worst:,.1f} codes; rounding to codes explains it: with a converter of 32 bits",
        f"it is {finest * verdict.constant / finer.constant:,.3f} of the same codes.",
    ]
    return lines


def drawn(verdict: CellSums) -> Any:
    """Estimated and analytic response, and the error of each cell."""
    with sheet(8.0, 6.0, "Impulse response of the accelerometer by its PN self-test") as figure:
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
        cells = np.arange(len(verdict.measured))
        above.vlines(cells, 0.0, verdict.analytic, color=GRID)
        above.plot(cells, verdict.analytic, "o", color=BLUE, markersize=9, fillstyle="none", label="analytic")
        above.plot(cells, verdict.measured, "x", color=ORANGE, label="estimated by the correlation cells")
        above.set_ylabel("sum of a period [codes]")
        above.legend()
        below.axhline(0.0, color=GRID)
        below.bar(cells, 100.0 * verdict.error, color=ORANGE)
        below.set(xlabel="cell: lag in chips", ylabel="error [%]", xticks=cells)
    return figure


def main(out: Path) -> int:
    """Run the self-test, print the comparison, write the report files; 0 when every cell is within 1 %."""
    with as_file(library_file(GRAPH)) as path:
        graph = read_graph(path)
    with progress(quiet=False) as bar:
        result = simulate(graph, engine="compiled", progress=bar)
    fine = graph.with_parameters({"adc.bits": 32})
    finer = judge(simulate(fine, samples=10_231, engine="compiled"))
    out.mkdir(parents=True, exist_ok=True)
    show_run(result, as_json=False)
    verdict = judge(result)
    print("\n".join(table(verdict, finer)))
    good = bool((np.abs(verdict.error[1:11]) <= 0.01).all())
    print(f"self-test {'passed' if good else 'FAILED'}: cells 1 to 10 within 1 % of the analytic response\n")
    figure = drawn(verdict)
    pictures = [save_figure(figure, out / f"impulse_response.{ending}").name for ending in ("svg", "png")]
    fragment = f'<div class="wide">{picture(figure, "impulse response")}</div>'
    lines = escape("\n".join(table(verdict, finer)))
    names = write_run(result, out, ("netcdf",), [("Impulse response", f"{fragment}\n<pre>{lines}</pre>")])
    print(f"written to {out}: {', '.join([*names, *pictures])}")
    return DONE if good else WRONG_MODEL


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "demo")))
