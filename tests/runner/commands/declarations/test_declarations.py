"""What the commands take: help for every option, and requests that hold exactly what is declared."""

import inspect
from importlib import import_module
from typing import get_type_hints

import click
import pytest

from proofmass.graphs.model.limits import LARGEST_SEED
from proofmass.runner.command_line import REQUESTS, cli
from proofmass.runner.commands.declarations.analysis import NoiseModelRequest
from proofmass.runner.commands.declarations.options import Request
from proofmass.runner.rtl.bench.simulators import Simulator
from proofmass.runner.rtl.tools.synth import ChipFamily

TYPES = {"Simulator": Simulator, "ChipFamily": ChipFamily}  # named for type checkers alone
OPTIONS = [
    pytest.param(option, id=f"{name}-{option.name}")
    for name, command in cli.commands.items()
    for option in command.params
    if isinstance(option, click.Option)
]


@pytest.mark.parametrize("kind", REQUESTS)
def test_a_request_has_a_field_with_a_type_for_each_option(kind: type[Request]) -> None:
    declared = {param.name: param for param in cli.commands[kind.command_name()].params}
    types = get_type_hints(kind, localns=TYPES)
    assert set(declared) == set(types) - {"does"}
    for name, param in declared.items():
        several = param.multiple if isinstance(param, click.Option) else param.nargs == -1
        assert several == str(types[name]).startswith("tuple") or param.nargs > 1, name
        assert (isinstance(param, click.Option) and param.is_flag and not several) or types[name] is not bool, name


@pytest.mark.parametrize("kind", REQUESTS)
def test_what_a_command_does_takes_its_request(kind: type[Request]) -> None:
    module, _, function = kind.does.partition(".")
    does = getattr(import_module(f"proofmass.runner.commands.{module}"), function)
    assert [parameter.annotation for parameter in inspect.signature(does).parameters.values()] == [kind]


def test_a_request_is_frozen() -> None:
    request = NoiseModelRequest(density="1 V/sqrt(Hz)")
    with pytest.raises(AttributeError, match="frozen"):
        request.density = "2 V/sqrt(Hz)"
    assert request.density == "1 V/sqrt(Hz)"


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
