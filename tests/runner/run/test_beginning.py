"""What blocks do before the first tick decides the bits as what they do in each tick does."""

import os
import signal
from collections.abc import Mapping
from pathlib import Path

import pytest

from proofmass.blocks.declaration.catalog import load_own_blocks
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.build import Graph
from proofmass.graphs.studies.build import Study
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.beginning import code_of
from proofmass.runner.run.simulate import simulate
from proofmass.runner.studies.kept.folder import kept_result
from proofmass.runner.studies.whole.study import run_study

OWN = """from typing import NamedTuple
from proofmass import Block, Buffer, param

LAW = {"slope": 2.0}  # read before the first tick alone

class Tally(Block):
    \"\"\"Count on from a start: out = gain * slope + offset + count.\"\"\"

    gain: float = param("1", "Gain.", default=1.0)
    offset: float = param("1", "Offset.", default=1.0)
    first = Buffer("Where it starts.", float, (1,))

class Constants(NamedTuple):
    level: float

class State(NamedTuple):
    count: float

@Tally.constants
def constants(p) -> Constants:
    return Constants(p.gain * LAW["slope"] + p.offset)

@Tally.start
def start(p, first) -> State:
    first[0] = 3.0
    return State(5.0)

@Tally.output("1")
def sum_of_all(p, x: State, first) -> float:
    \"\"\"Sum.\"\"\"
    return p.level + x.count + first[0]

@Tally.update
def update(p, x: State) -> State:
    return State(x.count + 1.0)
"""
CHANGES = {
    "a default": {'"Offset.", default=1.0': '"Offset.", default=2.0'},
    "data that constants read": {'"slope": 2.0': '"slope": 2.5'},
    "constants": {"p.gain * LAW": "p.gain + LAW"},
    "constants of other sensors than the first": {"p.gain * LAW": "p.gain * p.gain * LAW"},
    "the start": {"State(5.0)": "State(6.0)"},
    "what a buffer begins with": {"first[0] = 3.0": "first[0] = 4.0"},
}
every_change = pytest.mark.parametrize("changes", CHANGES.values(), ids=CHANGES)


def graph(folder: Path, changes: Mapping[str, str]) -> Graph:
    """A graph of the block, some lines of which are others."""
    text = OWN
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    (folder / "own.py").write_text(text)
    kind = load_own_blocks(folder / "own.py")["Tally"]
    measures = {"level": {"signal": "tally.sum_of_all", "statistic": "last"}}
    blocks = {"tally": kind()}
    return Graph(name="tally", rate="1 kHz", blocks=blocks, probes=["tally.sum_of_all"], measures=measures)


def interrupted(done: int, ticks: int) -> None:
    """Interrupt this process early in a run."""
    if 100 <= done < ticks:
        os.kill(os.getpid(), signal.SIGINT)


@pytest.mark.defect("S891", before="runs of two models in one ledger, without a word", after="belongs to another code")
@every_change
def test_a_ledger_is_refused_where_another_thing_is_done_before_the_first_tick(
    tmp_path: Path, changes: Mapping[str, str]
) -> None:
    spread = {"tally.gain": {"normal": 0.1}}
    study = Study(graph(tmp_path, {}).changed(samples=3), runs=2, spread=spread)
    kept = run_study(study, engine="python", folder=tmp_path / "kept")
    again = Study(graph(tmp_path, {}).changed(samples=3), runs=2, spread=spread)
    assert run_study(again, engine="python", folder=tmp_path / "kept").digest == kept.digest
    other = Study(graph(tmp_path, changes).changed(samples=3), runs=4, spread=spread)
    with pytest.raises(ModelError, match="belongs to another code"):
        run_study(other, engine="python", folder=tmp_path / "kept")


OFF_NOMINAL = {
    "constants": {"p.gain * LAW": "(p.gain if p.gain < 1.9 else 3.0) * LAW"},
    "a function that they call": {"twice(1.0) if": "twice(1.0) * 1.5 if"},
    "data that they read": {'"beyond": 7.0': '"beyond": 8.0'},
    "the start": {"State(5.0)": "State(5.0 if block.gain < 1.9 else 6.0)", "def start(p,": "def start(block,"},
    "a requirement": {"p.gain >= 1e3": "p.gain >= 1.9"},
    "a bound": {'"Gain.", default=1.0': '"Gain.", default=1.0, below=1.9'},
}
BEYOND = {
    'LAW = {"slope": 2.0}': 'LAW = {"slope": 2.0, "beyond": 7.0}',
    "p.offset)": 'p.offset + (LAW["beyond"] + twice(1.0) if p.gain > 1.9 else 0.0))',
    "@Tally.start": """def twice(x: float) -> float:
    return 2.0 * x

@Tally.requires
def positive(p):
    if p.gain >= 1e3:
        yield "gain", "below a thousand"

@Tally.start""",
}


@pytest.mark.defect("S954", before="sensors of two models in one table", after="belongs to another code")
@pytest.mark.parametrize("changes", OFF_NOMINAL.values(), ids=OFF_NOMINAL)
def test_a_ledger_is_refused_where_sensors_beyond_the_first_would_be_others(
    tmp_path: Path, changes: Mapping[str, str]
) -> None:
    """A tenth of the sensors have a gain above 1.9; the nominal and the first one have not."""
    spread = {"tally.gain": {"uniform": 1.0}}
    study = Study(graph(tmp_path, BEYOND).changed(samples=3), runs=2, seed=3, spread=spread)
    assert study.drawn(0)[0]["tally.gain"] < 1.9
    run_study(study, engine="python", folder=tmp_path / "kept")
    commented = {**BEYOND, "return 2.0 * x": '"""Double."""\n    return 2.0 * x  # twice'}
    commented["@Tally.start"] = BEYOND["@Tally.start"]
    other = Study(graph(tmp_path, {**BEYOND, **changes}).changed(samples=3), runs=20, seed=3, spread=spread)
    with pytest.raises(ModelError, match="belongs to another code"):
        run_study(other, engine="python", folder=tmp_path / "kept")


@pytest.mark.defect(
    "S936", before="runs with gains of about 1 told to be of about 4", after="refused, with what differs"
)
def test_runs_are_shown_about_the_default_that_they_were_drawn_about(tmp_path: Path) -> None:
    kept, changes = tmp_path / "kept", {'"Gain.", default=1.0': '"Gain.", default=4.0'}
    spread = {"tally.gain": {"normal": 0.1}}
    run_study(Study(graph(tmp_path, {}).changed(samples=3), runs=2, spread=spread), engine="python", folder=kept)
    (gain,) = (line for line in (kept / "study.toml").read_text().splitlines() if line.startswith("gain"))
    assert gain == "gain = 1.0"
    graph(tmp_path, changes)
    with pytest.raises(ModelError, match="belongs to another graph") as refused:
        kept_result(kept, load_own_blocks(tmp_path / "own.py"))
    assert refused.value.problems[0].got == "+gain = 1.0"


@pytest.mark.defect("S892", before="the rest of another model's run", after="the code of a block changed")
@pytest.mark.parametrize("changed", sorted(CHANGES.keys() - {"constants of other sensors than the first"}))
def test_a_checkpoint_is_refused_where_another_thing_is_done_before_the_first_tick(
    tmp_path: Path, changed: str
) -> None:
    out = tmp_path / "out"

    simulate(graph(tmp_path, {}), samples=2000, engine="python", folder=out, progress=interrupted)
    with pytest.raises(ModelError, match="the code of a block changed"):
        simulate(graph(tmp_path, CHANGES[changed]), samples=2000, engine="python", folder=out, resume=True)


def test_words_and_order_of_a_file_change_nothing(tmp_path: Path) -> None:
    same = {"read before": "a table that is read before", "import Block, Buffer, param": "import param, Buffer, Block"}
    assert code_of(plan(graph(tmp_path, {}))) == code_of(plan(graph(tmp_path, same)))
