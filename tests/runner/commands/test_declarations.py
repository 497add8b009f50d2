"""What the commands take: help for every option, and requests that hold exactly what is declared."""

import dataclasses
from typing import Any

import click
import pytest

from proofmass.graphs.model.limits import LARGEST_SEED
from proofmass.runner.command_line import cli
from proofmass.runner.commands.fit_command import FitRequest
from proofmass.runner.commands.margins_command import MarginsRequest
from proofmass.runner.commands.montecarlo_command import StudyRequest
from proofmass.runner.commands.rtl_command import RtlRequest
from proofmass.runner.commands.run_command import RunRequest

REQUESTS = {
    "run": RunRequest,
    "fit": FitRequest,
    "margins": MarginsRequest,
    "montecarlo": StudyRequest,
    "rtl": RtlRequest,
}
OPTIONS = [
    pytest.param(option, id=f"{name}-{option.name}")
    for name, command in cli.commands.items()
    for option in command.params
    if isinstance(option, click.Option)
]


@pytest.mark.parametrize(("name", "request_type"), REQUESTS.items())
def test_a_request_has_a_field_for_each_option(name: str, request_type: Any) -> None:
    declared = {param.name for param in cli.commands[name].params}
    assert {field.name for field in dataclasses.fields(request_type)} == declared


@pytest.mark.parametrize("option", OPTIONS)
def test_help_is_a_sentence(option: click.Option) -> None:
    text = option.help or ""
    assert text[:1].isupper()
    assert text.endswith(".")
    assert len(text) < 130


@pytest.mark.parametrize("name", cli.commands)
def test_the_first_sentence_fits_the_list_of_commands(name: str) -> None:
    assert "..." not in cli.commands[name].get_short_help_str(limit=62)


def test_the_largest_seed_is_that_of_graphs() -> None:
    kinds = [option.type for command in cli.commands.values() for option in command.params if option.name == "seed"]
    assert len(kinds) >= 3
    assert all(isinstance(kind, click.IntRange) and (kind.min, kind.max) == (0, LARGEST_SEED) for kind in kinds)
