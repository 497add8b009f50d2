"""Files of subgraphs made to escape, to go round in circles or to explode: refused at once, and nothing is read."""

import os
import time
from pathlib import Path

import pytest

from proofmass.blocks import Gain
from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.checks.check import check
from proofmass.graphs.files.toml_reader import read_graph, read_graph_text
from proofmass.graphs.model.build import Graph

SECONDS = 0.5
GAIN = '[blocks.gain]\nkind = "Constant"\n'


def using(name: str, more: str = "") -> str:
    return f'[blocks.part]\ngraph = "{name}"\n{more}'


def refused(file: Path) -> tuple[Problem, ...]:
    began = time.thread_time()
    with pytest.raises(ModelError) as caught:
        read_graph(file)
    assert time.thread_time() - began < SECONDS
    return caught.value.problems


def test_a_file_that_contains_itself(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(using("a.toml"))
    (problem,) = refused(tmp_path / "a.toml")
    assert problem.message == "the file contains itself: a.toml -> a.toml"


def test_a_circle_of_files_names_the_chain(tmp_path: Path) -> None:
    for name, other in (("a", "b"), ("b", "c"), ("c", "a")):
        (tmp_path / f"{name}.toml").write_text(using(f"{other}.toml"))
    (problem,) = refused(tmp_path / "a.toml")
    assert (
        str(problem).replace(f"{tmp_path}/", "")
        == """\
c.toml:2: blocks.part.graph: the file contains itself: a.toml -> b.toml -> c.toml -> a.toml
  got:      'a.toml'
  hint:     take one of these steps out"""
    )


def test_a_circle_through_a_link(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(using("b.toml"))
    (tmp_path / "b.toml").symlink_to(tmp_path / "a.toml")
    assert "contains itself" in refused(tmp_path / "a.toml")[0].message


@pytest.mark.parametrize(
    "name",
    ["../secret.toml", "/etc/passwd", "inner/../../secret.toml", "link.toml", "folder/secret.toml"],
)
def test_a_file_outside_the_folder_is_not_read(name: str, tmp_path: Path) -> None:
    (tmp_path / "secret.toml").write_text("secret = 1\n")
    inside = tmp_path / "inside"
    (inside / "inner").mkdir(parents=True)
    (inside / "link.toml").symlink_to(tmp_path / "secret.toml")
    (inside / "folder").symlink_to(tmp_path)
    (inside / "a.toml").write_text(using(name))
    (problem,) = refused(inside / "a.toml")
    assert problem.message == "the file lies outside the folder of this one"


def test_the_library_is_the_only_other_place(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(using("library:closed_loop_accelerometer.toml") + 'rate = "10 kHz"\n')
    assert "part.dac" in {f"part.{name}" for name in read_graph(tmp_path / "a.toml").subgraphs["part"].blocks}
    (tmp_path / "a.toml").write_text(using("library:../check.py"))
    assert refused(tmp_path / "a.toml")[0].message == "the library has no file ../check.py"


@pytest.mark.parametrize(
    "name", ["", "missing.toml", "folder", "pipe", "a\\u0000b", "x" * 500, "https://example.org/a.toml"]
)
def test_what_is_no_file(name: str, tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "a.toml").write_text(using(name))
    (problem,) = refused(tmp_path / "a.toml")
    assert problem.key == "blocks.part.graph"
    assert problem.line == 2


def test_a_million_blocks_by_nesting_files(tmp_path: Path) -> None:
    (tmp_path / "0.toml").write_text(GAIN)
    for level in range(1, 7):
        (tmp_path / f"{level}.toml").write_text(using(f"{level - 1}.toml", "count = 10\n"))
    (problem,) = refused(tmp_path / "6.toml")
    assert problem.message == "too many blocks with those inside the subgraphs"
    assert problem.got == "100000"
    (tmp_path / "b.toml").write_text(using("4.toml"))
    assert read_graph(tmp_path / "b.toml").size.blocks == 10_000


def test_a_million_blocks_by_nesting_values() -> None:
    graph = Graph(name="", rate=1, blocks={"gain": Gain()})
    began = time.thread_time()
    for _ in range(4):
        graph = Graph(name="", rate=1, blocks={f"part_{n}": graph for n in range(10)})
    with pytest.raises(ModelError, match="too many blocks with those inside the subgraphs"):
        Graph(name="", rate=1, blocks={f"part_{n}": graph for n in range(100)})
    assert time.thread_time() - began < SECONDS


def test_wires_are_limited_too() -> None:
    wires = [f"a.output -> b{n}.input" for n in range(20_000)]
    part = Graph(name="", blocks={"gain": Gain()}, wires=wires)
    with pytest.raises(ModelError, match="too many wires with those inside the subgraphs"):
        Graph(name="", blocks={f"part_{n}": part for n in range(100)})


def test_a_long_chain_of_files(tmp_path: Path) -> None:
    for level in range(1000):
        (tmp_path / f"{level}.toml").write_text(using(f"{level + 1}.toml"))
    assert refused(tmp_path / "0.toml")[0].message == "subgraphs nested deeper than 15 levels"


def test_deep_tables() -> None:
    text = "x = " + "{ blocks.a = " * 30 + "1" + " }" * 30
    began = time.thread_time()
    with pytest.raises(ModelError, match="subgraphs nested deeper than 15 levels"):
        read_graph_text(text.replace("x = { blocks.a", "blocks.a", 1).replace("}", "", 1))
    assert time.thread_time() - began < SECONDS


def test_many_large_files(tmp_path: Path) -> None:
    text = GAIN + "#" * (1 << 19)
    uses = []
    for number in range(20):
        (tmp_path / f"{number}.toml").write_text(text)
        uses.append(f'[blocks.part_{number}]\ngraph = "{number}.toml"\n')
    (tmp_path / "a.toml").write_text("".join(uses))
    assert {p.message for p in refused(tmp_path / "a.toml")} == {
        "the files of the graph are larger than 4 MiB together"
    }


def test_one_part_many_times_is_read_once(tmp_path: Path) -> None:
    (tmp_path / "large.toml").write_text("rate = 1\n" + GAIN + "#" * (1 << 19))
    (tmp_path / "a.toml").write_text(using("large.toml", 'count = 2000\n"gain.value" = 3\n'))
    began = time.thread_time()
    graph = read_graph(tmp_path / "a.toml")
    assert len(graph.subgraphs) == 2000
    assert all(problem.note for problem in check(graph))
    assert time.thread_time() - began < 4.0
