"""What the commands take: help for every option, and requests that hold exactly what is declared."""

import inspect
import json
from importlib import import_module
from typing import get_type_hints

import click
import pytest

from proofmass.graphs.model.limits import LARGEST_SEED
from proofmass.runner.command_line import REQUESTS, cli, command_of
from proofmass.runner.commands.declarations.analysis import NoiseModelRequest
from proofmass.runner.commands.declarations.design import SigmaDeltaRequest
from proofmass.runner.commands.declarations.options import Request, option
from proofmass.runner.design.modulators.modulator import design_modulator
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


def test_a_field_named_as_a_parameter_needs_no_other_line(capsys: pytest.CaptureFixture[str]) -> None:
    class Tried(SigmaDeltaRequest, does=SigmaDeltaRequest.does):
        samples: int = option("Simulate this many values.", type=int, default=1024)

    peaks = []
    for words in (["--samples", "2048"], []):
        command_of(Tried).main([*words, "--order", "1", "--json"], standalone_mode=False)
        peaks.append(json.loads(capsys.readouterr().out)["peak"]["ratio"])
    assert peaks == [design_modulator(1, 64.0, samples=samples).peak[1] for samples in (2048, 1024)]
    assert peaks[0] != peaks[1]


def test_what_a_call_is_given_comes_before_the_fields() -> None:
    class Few(Request):
        gain: float = option("Gain.")
        zeros: str = option("Zeros.")

    def used(order: int, gain: float, zeros: str = "", poles: str = "none") -> tuple[int, float, str, str]:
        return order, gain, zeros, poles

    few = Few(gain=2.0, zeros="all")
    assert few.call(used, 3) == (3, 2.0, "all", "none")
    assert few.call(used, 3, 5.0, zeros="few") == (3, 5.0, "few", "none")


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
