"""The engines: what each is, what it can do and how a run starts on it.

Choices of the command line, provenance and repeat commands derive from `ENGINES`. The module
imports nothing that takes time, since the command line reads it for its help.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal, Protocol, get_args

from proofmass.blocks.declaration.problem import Problem, did_you_mean, shown

if TYPE_CHECKING:
    from proofmass.runner.plan.memory import Engine, Memory
    from proofmass.runner.plan.planned import Plan

EngineName = Literal["auto", "python", "compiled", "cxxrtl"]


class Starter(Protocol):
    """Starts a run from a memory, of the plan that was prepared or of one that differs from it in numbers alone."""

    def __call__(self, plan: "Plan", seed: int, run: int, memory: "Memory") -> "Engine": ...


@dataclass(frozen=True)
class EngineFacts:
    """Facts of an engine that are known before anything is imported for it."""

    prepare: Callable[["Plan", int], Starter]  # does once, for all runs of a plan, what takes long; ticks of all
    libraries: tuple[str, ...]  # whose versions a result states
    studies: bool = True  # whether runs of a study may use it
    threads: bool = False  # whether runs of a study gain from threads
    lanes: bool = False  # whether runs of a study go side by side in vectors
    machine_code: bool = False  # whether a result states the processor the loop was compiled for


def _python(plan: "Plan", ticks: int) -> Starter:
    # for start-up time: the table is read by the command line's help
    from proofmass.runner.reference.interpret import Interpreter

    return lambda plan, seed, run, memory: Interpreter(plan, seed, run, memory.copy())


def _compiled(plan: "Plan", ticks: int) -> Starter:
    # for start-up time: plain Python needs no compiler
    from proofmass.runner.run.estimates import is_short
    from proofmass.runner.targets.native import CompiledLoop, CompiledPlan

    compiled = CompiledPlan(plan, quick=is_short(plan, ticks))
    return lambda plan, seed, run, memory: CompiledLoop(plan, seed, run, memory, compiled)


def _cxxrtl(plan: "Plan", ticks: int) -> Starter:
    # for start-up time: only this engine needs models of hardware
    from proofmass.runner.rtl.model.co_simulation import CoSimulation

    return CoSimulation


ENGINES: Mapping[str, EngineFacts] = MappingProxyType(
    {
        "python": EngineFacts(_python, libraries=("numpy",)),
        "compiled": EngineFacts(
            _compiled, libraries=("numpy", "llvmlite"), threads=True, lanes=True, machine_code=True
        ),
        "cxxrtl": EngineFacts(_cxxrtl, libraries=("numpy", "llvmlite", "pyosys"), studies=False, machine_code=True),
    }
)


def engine_choices(studies: bool = False) -> tuple[str, ...]:
    """Return the names a caller may give, "auto" first; those that run studies if `studies`."""
    return ("auto", *(name for name, facts in ENGINES.items() if facts.studies or not studies))


def engine_problems(name: object, studies: bool = False) -> list[Problem]:
    """Return what is wrong with the name of an engine that a caller gave."""
    choices = engine_choices(studies)
    if name in choices:
        return []
    message = "runs no studies" if name in get_args(EngineName) else "there is no such engine"
    hint = did_you_mean(str(name), choices, "the engines")
    return [Problem(message=message, key="engine", got=shown(name), hint=hint)]
