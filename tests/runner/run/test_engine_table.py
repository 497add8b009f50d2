"""One table of engines: what may be chosen, what a result states, and what starts."""

from typing import get_args

import click
import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.studies.study_reader import read_study_text
from proofmass.runner.command_line import cli
from proofmass.runner.plan.memory import start
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.engine_table import ENGINES, EngineName, engine_choices
from proofmass.runner.run.engines import make_engine
from proofmass.runner.run.provenance import provenance
from proofmass.runner.run.simulate import simulate
from proofmass.runner.studies.runs.sensor_runs import SensorRuns
from proofmass.runner.studies.whole.study import run_study
from tests.by_hand.graph_texts import SMALL
from tests.by_hand.study_texts import STUDY


def test_the_type_of_names_is_that_of_the_table() -> None:
    assert get_args(EngineName) == ("auto", *ENGINES)


@pytest.mark.parametrize(("command", "studies"), [("run", False), ("fit", False), ("montecarlo", True)])
def test_the_commands_offer_what_the_table_has(command: str, studies: bool) -> None:
    (kind,) = [option.type for option in cli.commands[command].params if option.name == "engine"]
    assert isinstance(kind, click.Choice)
    assert tuple(kind.choices) == engine_choices(studies)
    assert ("cxxrtl" in kind.choices) is not studies


@pytest.mark.parametrize("name", ["python", "compiled"])
def test_an_engine_has_the_name_that_it_has_in_the_table(name: str) -> None:
    planned = plan(read_graph_text(SMALL))
    assert make_engine(planned, name, 0, 0, start(planned), 1).name == name


@pytest.mark.parametrize("name", ENGINES)
def test_provenance_states_the_versions_of_its_libraries(name: str) -> None:
    stated = provenance(read_graph_text(SMALL), name)
    assert stated["engine"] == name
    others = {library for facts in ENGINES.values() for library in facts.libraries} - set(ENGINES[name].libraries)
    assert set(ENGINES[name].libraries) <= stated.keys()
    assert not others & stated.keys()


def test_an_unknown_engine_is_refused_with_the_nearest_name() -> None:
    for wrong in (
        lambda: simulate(read_graph_text(SMALL), engine="compield"),  # type: ignore[arg-type]
        lambda: run_study(read_study_text(STUDY), engine="compield"),  # type: ignore[arg-type]
    ):
        with pytest.raises(ModelError, match=r"(?s)no such engine.*compield.*did you mean compiled\?"):
            wrong()


def test_a_study_refuses_an_engine_for_single_runs() -> None:
    with pytest.raises(ModelError, match=r"(?s)engine: runs no studies.*cxxrtl.*auto, python, compiled"):
        SensorRuns(read_study_text(STUDY), "cxxrtl")
