"""Files of the library by "library:NAME", in Python as in commands."""

from collections.abc import Callable
from pathlib import Path

import pytest

from proofmass import ModelError, read_graph, read_study, read_tuning
from proofmass.graphs.files.library import file_of, library_file


@pytest.mark.parametrize("name", ["library:template", "library:template.toml"])
def test_a_graph_of_the_library_is_read_by_its_name(name: str) -> None:
    assert file_of(name) == library_file("template.toml")
    assert read_graph(name) == read_graph(library_file("template.toml"))


def test_a_study_of_the_library_is_read_by_its_name() -> None:
    assert read_study("library:scale_factor_drift").runs == 200


def test_other_paths_stay_as_they_are() -> None:
    assert file_of("folder/sensor.toml") == Path("folder/sensor.toml")


@pytest.mark.parametrize("read", [read_graph, read_study, read_tuning])
def test_a_name_that_the_library_lacks_is_answered_with_the_nearest(read: Callable[[str], object]) -> None:
    with pytest.raises(ModelError, match="did you mean library:closed_loop_accelerometer") as refused:
        read("library:closed_loop_acelerometer")
    assert refused.value.problems[0].file == "library:closed_loop_acelerometer"
