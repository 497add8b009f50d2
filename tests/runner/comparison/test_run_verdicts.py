"""Two runs that differ are not told the same: in units, in last bits, in blocks of their own, in how loops end."""

from pathlib import Path

import h5netcdf
import numpy as np
import pytest

from proofmass.blocks.declaration.catalog import load_own_blocks
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.runner.comparison.runs import Allowance, TraceChange, _trace, compare_runs
from proofmass.runner.output.export import save_netcdf, save_summary
from proofmass.runner.run.simulate import simulate
from tests.by_hand.design_texts import INTEGRATING

LEVEL = """\
name = "a level"
rate = "1 kHz"
samples = 3

[measures]
level = { signal = "source.output", statistic = "mean" }

[blocks]
source = { kind = "Constant", value = 2, unit = "V" }
"""
OWN = """from proofmass import Block, param

class Level(Block):
    \"\"\"Show a level: level = height.\"\"\"

    height: float = param("1", "Height.", default=1.0)

@Level.output("1")
def level(p) -> float:
    \"\"\"Level.\"\"\"
    return p.height
"""
OF_OWN = """\
name = "own"
rate = "1 kHz"
samples = 3
probes = ["source.level"]
blocks.source = { kind = "Level", height = 2 }
"""
MOVING = INTEGRATING.replace('"0.5 s"', '"60 ms"').replace(
    "wires = [", 'wires = [\n    "level.output -> controller.gain",'
)
MOVING += '\n[blocks.level]\nkind = "Step"\noffset = 100.0\namplitude = 0.0\nstart_time = "5 ms"\n'


def saved(folder: Path, text: str, own: Path | None = None) -> Path:
    """The folder of a run."""
    result = simulate(read_graph_text(text, own=load_own_blocks(own) if own else None), engine="python")
    folder.mkdir()
    save_netcdf(result, folder / "traces.nc")
    save_summary(result, folder / "summary.json")
    return folder


@pytest.mark.defect("S893", before="2 V and 2 mV were the same", after="another unit is another measure")
def test_measures_in_other_units_differ(tmp_path: Path) -> None:
    texts = LEVEL, LEVEL.replace('"V"', '"mV"')
    folders = [saved(tmp_path / str(number), text) for number, text in enumerate(texts)]
    found = compare_runs(*folders, Allowance(relative=0.5))
    (level,) = found.measures
    assert (level.unit, level.before, level.after) == ("V, now mV", 2.0, 2.0)
    assert not found.same


@pytest.mark.parametrize(
    ("before", "after", "largest", "first"),
    [
        ([2**53, 2**53, 5], [2**53, 2**53 + 1, 5], 1.0, 0.1),
        ([-(2**62), 7, 5], [-(2**62) + 1, 9, 5], 2.0, 0.0),
        ([2**62, 7, 5], [2**62, 7, 5], 0.0, None),
        ([0.0, 0.0, 1.0], [0.0, -0.0, 1.0], 5e-324, 0.1),
        ([-0.0, np.nan, np.inf], [-0.0, np.nan, np.inf], 0.0, None),
    ],
    ids=["one beyond 53 bits", "one of 62 bits", "the same integers", "the sign of zero", "the same bits"],
)
@pytest.mark.defect("S894", before="same bits", after="first row that differs")
def test_every_bit_counts(
    before: list[float], after: list[float], largest: float, first: float | None, tmp_path: Path
) -> None:
    files = []
    for name, values in (("before", before), ("after", after)):
        files.append(tmp_path / f"{name}.nc")
        with h5netcdf.File(files[-1], "w") as data:
            data.dimensions["time"] = 3
            data.create_variable("time", ("time",), data=np.array([0.0, 0.1, 0.2]))
            data.create_variable("signal", ("time",), data=np.array(values))
    with h5netcdf.File(files[0], "r") as one, h5netcdf.File(files[1], "r") as other:
        found = _trace("signal", one, other, Allowance())
        within = _trace("signal", one, other, Allowance(absolute=2.0))
    rms = largest / np.sqrt(3.0) if largest == 1.0 else found.rms
    assert found == TraceChange("signal", "", 3, largest, pytest.approx(rms), 0.0, first)
    assert within.same


@pytest.mark.parametrize(
    ("before", "after", "apart"),
    [(2**62, 2**62 + 3, 3), (2**62 + 700, 2**62, 700), (-(2**63), 2**63 - 1, 2**64 - 1), (-(2**62) - 5, -(2**62), 5)],
)
@pytest.mark.defect("S953", before="3 apart at 2^62 was 1, 700 apart 1024", after="as far as the integers are")
def test_large_integers_are_as_far_apart_as_they_are(before: int, after: int, apart: int, tmp_path: Path) -> None:
    files = []
    for name, value in (("before", before), ("after", after)):
        files.append(tmp_path / f"{name}.nc")
        with h5netcdf.File(files[-1], "w") as data:
            data.dimensions["time"] = 2
            data.create_variable("time", ("time",), data=np.array([0.0, 0.1]))
            data.create_variable("signal", ("time",), data=np.array([5, value]))
    with h5netcdf.File(files[0], "r") as one, h5netcdf.File(files[1], "r") as other:
        within, beyond = (_trace("signal", one, other, Allowance(absolute=apart + off)) for off in (0.0, -1.0))
    assert within.largest == float(apart)
    assert within.same
    assert beyond.same == (float(apart - 1) == float(apart))  # 2^64 - 1 and 2^64 - 2 are one double


@pytest.mark.defect("S904", before="a tolerance of NaN allowed all differences", after="none")
def test_a_tolerance_that_is_no_number_allows_nothing(tmp_path: Path) -> None:
    text = LEVEL.replace("[measures]", 'probes = ["source.output"]\n[measures]')
    folders = [saved(tmp_path / unit, text.replace("value = 2", f"value = {unit}")) for unit in ("2", "3")]
    (trace,) = compare_runs(*folders, Allowance(relative=np.nan)).traces
    assert (trace.largest, trace.first, trace.same) == (1.0, 0.0, False)


@pytest.mark.defect(
    "S895", before="graphs of own blocks were not compared, without a word", after="compared, or a note"
)
def test_graphs_of_own_blocks(tmp_path: Path) -> None:
    (tmp_path / "own.py").write_text(OWN)
    texts = OF_OWN, OF_OWN.replace("height = 2", "height = 3")
    folders = [saved(tmp_path / str(number), text, tmp_path / "own.py") for number, text in enumerate(texts)]
    known = compare_runs(*folders, Allowance(), load_own_blocks(tmp_path / "own.py"))
    assert [(d.key, d.before, d.after) for d in known.graph] == [("blocks.source.height", "2.0", "3.0")]
    assert not known.notes
    (note,) = compare_runs(*folders, Allowance()).notes
    assert note.startswith("graphs and margins are not compared: summary.json:")


@pytest.mark.defect("S896", before="margins of tick 0 alone", after="margins where `proofmass margins` takes them")
def test_margins_are_those_of_the_loop_as_it_ends(tmp_path: Path) -> None:
    """A gain that rises to 110 1/s after the start: K T = 2 sin(w T / 2), and a phase margin of 90 deg - 1.5 w T."""
    texts = MOVING, MOVING.replace("amplitude = 0.0", "amplitude = 10.0")
    folders = [saved(tmp_path / str(number), text) for number, text in enumerate(texts)]
    margins = {margin.name: margin for margin in compare_runs(*folders, Allowance()).margins}
    phases = [90.0 - 3.0 * np.degrees(np.arcsin(gain * 1e-3 / 2.0)) for gain in (100.0, 110.0)]
    phase = margins["main.phase_margin"]
    assert (phase.before, phase.after) == pytest.approx(tuple(phases), rel=1e-9)
