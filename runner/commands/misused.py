"""Mistakes of the shell: commands and options of other tools, values without quotes, files of another kind."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import click

from proofmass.blocks.declaration.other_functions import FUNCTIONS
from proofmass.blocks.declaration.problem import Problem, did_you_mean
from proofmass.blocks.declaration.unit_expressions import is_unit
from proofmass.runner.output.counts import is_number

_FUNCTIONS = {  # that a command calls, and whose names in other tools it has
    "run": ("simulate", "sweep"),
    "check": ("check",),
    "margins": ("margins", "linearise"),
    "response": ("response",),
    "noise": ("noise",),
    "spectrum": ("spectrum", "tones"),
    "allan": ("allan",),
    "montecarlo": ("run_study",),
    "worst": ("worst",),
    "tune": ("tune",),
    "fit": ("fit",),
    "prove": ("prove",),
}


def _elsewhere(functions: tuple[str, ...]) -> Iterator[str]:
    """Yield the names of functions, here and in other tools, that are not commands themselves."""
    for function in functions:
        yield from (word for word in (function.replace("_", "-"), *FUNCTIONS[function]) if word not in _FUNCTIONS)


ELSEWHERE: Mapping[str, tuple[str, ...]] = {  # a command or an option, and what other tools call it
    **{command: tuple(_elsewhere(functions)) for command, functions in _FUNCTIONS.items()},
    "new": ("init", "create", "make", "template", "generate", "copy"),
    "draw": ("diagram", "picture", "svg", "graphviz", "dot", "mermaid", "show"),
    "rtl": ("verilog", "hdl", "synth", "hardware", "codegen"),
    "live": ("serve", "gui", "watch", "edit", "open", "ui"),
    "gallery": ("library", "examples", "list", "models", "demo"),
    "blocks": ("block", "kinds", "components", "catalogue", "catalog"),
    "explain": ("error", "code", "help-code"),
    "diff": ("compare", "cmp"),
    "verify": ("requirements", "golden", "accept"),
    "test-block": ("test",),
    "--help": ("help", "usage", "man"),
    "--version": ("version",),
    "--duration": ("--time", "--length", "--stop-time", "--tstop", "--t-end", "--until", "--seconds", "--stop"),
    "--samples": ("--steps", "--ticks", "--n", "--points"),
    "--runs": ("--count", "--sensors", "--trials", "--iterations", "--samples"),
    "--set": ("--param", "--params", "--parameter", "--value", "--override", "--define"),
    "--probe": ("--signal", "--record", "--log", "--observe", "--port"),
    "--out": ("--folder", "--dir", "--directory", "--save", "--outdir", "--results"),
    "--plot": ("--figure", "--picture", "--image", "--svg", "--png", "--bode"),
    "--threads": ("--jobs", "--workers", "--processes", "--cores", "--parallel"),
    "--workers": ("--jobs", "--threads", "--processes", "--cores", "--parallel"),
    "--json": ("--machine", "--raw"),
    "--quiet": ("--silent", "--no-progress"),
    "--band": ("--range", "--frequencies", "--freq"),
    "--loop": ("--open-at", "--at-output", "--break"),
    "--engine": ("--backend", "--solver"),
    "--from": ("--template", "--example", "--gallery"),
    "--tolerance": ("--rtol", "--relative"),
    "--absolute": ("--atol",),
    "--find": ("--search", "--grep"),
    "--blocks": ("--own", "--import", "--load", "--module"),
}


def meant(word: str, known: Mapping[str, object] | list[str], what: str) -> str:
    """Return a hint: the command or option others call so, or the nearest by its letters."""
    folded = word.lower().replace("_", "-")
    same = next((name for name, others in ELSEWHERE.items() if name in known and folded in others), "")
    return f"did you mean {same}?" if same else did_you_mean(word, known, what)


def answered(error: click.UsageError, words: list[str]) -> click.UsageError:
    """Return an error of click with its cure; `words` are those of the command line."""
    if error.ctx is None:
        return error
    options = [name for param in error.ctx.command.params if isinstance(param, click.Option) for name in param.opts]
    if isinstance(error, click.NoSuchOption):
        long = [name for name in options if name.startswith("--")]
        places = [param.human_readable_name for param in error.ctx.command.params if isinstance(param, click.Argument)]
        hint = meant(error.option_name, [*long, "--help"], "the options")
        if error.option_name.lstrip("-").upper() in places:  # as of a command that calls it so
            hint = f"write it by its place: {error.ctx.command_path} {' '.join(places)}"
        return click.UsageError(f"no such option: {error.option_name}; {hint}", error.ctx)
    cure = next(_unquoted(error.ctx.command, words), "") if error.message.startswith("Got unexpected extra") else ""
    return click.UsageError(f"{error.message}\n  hint:     {cure}", error.ctx) if cure else error


def _unquoted(command: click.Command, words: list[str]) -> Iterator[str]:
    """Yield the cure of each option whose value was typed with spaces and without quotes."""
    takes = {name: param for param in command.params if isinstance(param, click.Option) for name in param.opts}
    for place, word in enumerate(words):
        option = takes.get(word)
        if option is None or option.is_flag:
            continue
        values = _values(words[place + 1 :])
        if word in ("--set", "--sweep", "--tolerance", "--gain", "--amplitude", "--over"):
            joined = _assigned(values)
        else:
            joined = _quoted(values, option.nargs)
        if joined and joined != " ".join(values[: option.nargs]):
            yield f"write {word} {joined}" if '"' not in joined else f"quote it: {word} {joined}"


def _values(words: list[str]) -> list[str]:
    """Return the words up to the next option."""
    end = next((i for i, word in enumerate(words) if word.startswith("-") and not is_number(word)), len(words))
    return words[:end]


def _assigned(values: list[str]) -> str:
    """Return one NAME=VALUE of words such as `adc.bits 12`, `adc.bits = 12` or `mass=50 ug`; empty where it is one."""
    if not values or (len(values) < 2):
        return ""
    name, _, first = values[0].partition("=")
    rest = [word for word in ([first] if first else []) + values[1:] if word != "="]
    rest[0] = rest[0].removeprefix("=")
    value = rest[0]
    if len(rest) > 1 and is_number(value) and is_unit(rest[1]):
        value = f"{value} {rest[1]}"
    elif "=" in values[0] and first:
        return ""
    return f'"{name}={value}"' if " " in value else f"{name}={value}"


def _quoted(values: list[str], count: int) -> str:
    """Return as many quantities in quotes, of words as `1 Hz 100 Hz`; empty for other words."""
    pairs = [f'"{a} {b}"' for a, b in zip(values[::2], values[1::2], strict=False) if is_number(a) and is_unit(b)]
    return " ".join(pairs[:count]) if len(pairs) >= count else ""


def under_options(problems: Iterable[Problem], options: Mapping[str, Any], command: click.Command) -> list[Problem]:
    """Return problems of which those of values of the command line are named by their options."""
    said = dict[str, click.Parameter]()
    for param in command.params:
        given = options.get(param.name or "")
        values = given if isinstance(given, tuple) else (given,)
        said |= {text.partition("=")[0]: param for text in values if isinstance(text, str) and text}
    return [_named(problem, said) for problem in problems]


def _named(problem: Problem, said: Mapping[str, click.Parameter]) -> Problem:
    param = said.get(problem.key)
    if param is None or problem.file:
        return problem
    name = next((name for name in param.opts if name.startswith("--")), (param.name or "").upper())
    return replace(problem, key=f"{name} {problem.key}")
