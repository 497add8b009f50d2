"""Answers of commands: exit codes, text for people or JSON for programs, then the files that were written."""

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import click

from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.host.named_files import write_text
from proofmass.runner.output.json_text import json_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from proofmass.blocks.declaration.problem import Problem

_Question = TypeVar("_Question")
_Answer = TypeVar("_Answer")

DONE = 0  # exit codes of every command
WRONG_MODEL = 1  # the graph or study has problems, or a check of it failed
USAGE = 2  # an option is wrong or missing
FAILED = 3  # the run failed, or a file could not be read or written
INTERRUPTED = 130  # by Ctrl-C or SIGTERM


def print_problem(problem: "Problem", err: bool = True) -> None:
    """Print a problem or a note; on a terminal its place in bold, and the cure in colour.

    Nothing is coloured where NO_COLOR is set (https://no-color.org) or the terminal is "dumb".
    """
    head, *rows = str(problem).split("\n")
    if os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb":
        click.echo("\n".join([head, *rows]), err=err)
        return
    head = click.style(head, fg="yellow" if problem.note else "red", bold=True)
    rows = [click.style(row, fg="green") if row.startswith("  hint:") else row for row in rows]
    click.echo("\n".join([head, *rows]), err=err)


def print_json(data: Any) -> None:
    """Print plain data as JSON."""
    click.echo(json_text(data))


def print_answer(as_json: bool, data: Callable[[], Any], lines: Iterable[str]) -> None:
    """Print plain data as JSON for a program, or lines for people."""
    if as_json:
        print_json(data())
    else:
        print_text(lines)


def print_picture(draw: Callable[[], "Figure"], path: Path | None, as_json: bool = False) -> None:
    """Write a picture where a file is named for it, and say so."""
    if path is not None:
        # start-up time: few answers are drawn
        from proofmass.runner.output.pictures import save_figure

        print_file(save_figure(draw(), path), as_json)


def print_pictures(figures: Mapping[str, Callable[[], "Figure"]], path: Path | None, as_json: bool) -> None:
    """Write pictures where a file is named for them; with their own names in that name if there are several."""
    for name, draw in figures.items():
        named = path.with_stem(f"{path.stem}_{name}") if path is not None and len(figures) > 1 else path
        print_picture(draw, named, as_json)


class Shown(NamedTuple):
    """One of several answers: its name, lines for people, plain data, and its picture."""

    name: str
    lines: Iterable[str]
    data: Callable[[], Any]
    draw: Callable[[], "Figure"]


def attempted(ask: Callable[[_Question], _Answer], questions: Iterable[_Question]) -> "Iterator[_Answer | ModelError]":
    """Yield the answers to some questions, or why one has none."""
    for question in questions:
        try:
            yield ask(question)
        except ModelError as error:
            yield error


def print_answers(answers: "Iterable[Shown | ModelError]", alone: bool, path: Path | None, as_json: bool) -> int:
    """Print answers and write their pictures, and return the exit code; `alone` is one, whose data are no list.

    Raises a `ModelError` of all that have none.
    """
    every = list(answers)
    told = [answer for answer in every if isinstance(answer, Shown)]
    if told:
        lines = (line for answer in told for line in answer.lines)
        print_answer(as_json, lambda: told[0].data() if alone else [answer.data() for answer in told], lines)
    print_pictures({answer.name: answer.draw for answer in told}, path, as_json)
    problems = [problem for answer in every if isinstance(answer, ModelError) for problem in answer.problems]
    if problems:
        raise ModelError(problems)
    return DONE


def print_text(lines: Iterable[str], err: bool = False) -> None:
    """Print lines; nothing if there are none."""
    for line in lines:
        click.echo(line, err=err)


def print_files(folder: Path, names: Iterable[str], as_json: bool) -> None:
    """Say which files a folder has got; on standard error where JSON is on standard output."""
    click.echo(f"written to {folder}: {', '.join(names)}", err=as_json)


def print_file(path: Path, as_json: bool = False) -> None:
    """Say which file was written; on standard error where JSON is on standard output."""
    click.echo(f"wrote {path}", err=as_json)


def write_or_print(text: str, output: Path | None, as_json: bool = False) -> None:
    """Write a text to a file, or print it without one; `as_json`: is JSON on standard output."""
    if output is None:
        click.echo(text)
    else:
        write_text(output, text if text.endswith("\n") else text + "\n")
        print_file(output, as_json)


def print_interruption(done: str, folder: Path | None, cure: str) -> int:
    """Say how far an interrupted command got and how to go on; returns the exit code."""
    kept = f"; kept in {folder}" if folder is not None else ""
    click.echo(f"interrupted after {done}{kept}\n  hint:     {cure}", err=True)
    return INTERRUPTED
