"""Which engine runs a plan, and how one is made."""

from typing import Literal

from proofmass.runner.engine.interpret import Interpreter
from proofmass.runner.engine.memory import Engine, Memory
from proofmass.runner.engine.planned import Plan

EngineName = Literal["auto", "python", "compiled", "cxxrtl"]

LANES = (64, 32, 16)  # to choose from; loops over 8 are taken apart by the compiler and get no vectors
INTERPRETED_SECONDS = 1.0  # what plain Python may take before compiling is worth it
_INTERPRETED_STEP = 1.5e-6  # seconds a function and tick in plain Python, measured
_INTERPRETED_ENTRY = 0.15e-6  # and an entry of a buffer
_INTERPRETED_LINE = 0.5e-6  # and a line of integer code, which the reference takes apart in `FixedValue`


def choose(planned: Plan, ticks: int, wanted: EngineName) -> str:
    """The engine that is ready sooner: short runs are interpreted, long ones and ones compiled before are compiled."""
    if wanted != "auto":
        return wanted
    entries = sum(len(held) for node, held in planned.buffers.items() if node not in planned.recorded)
    if any(block.wide for block in planned.digital.values()):
        return "python"
    lines = sum(s.code.source.count("\n") for block in planned.digital.values() for s in block.steps.values())
    tick = len(planned.schedule.order) * _INTERPRETED_STEP + entries * _INTERPRETED_ENTRY + lines * _INTERPRETED_LINE
    seconds = ticks * tick
    if seconds < 0.1:
        return "python"
    if seconds > INTERPRETED_SECONDS:
        return "compiled"
    from proofmass.runner.engine.native import already_compiled

    return "compiled" if already_compiled(planned) else "python"


def lanes_for(runs: int) -> int:
    """How many lanes suit so many compiled runs: the most that are filled several times over; 0 for a few runs."""
    return next((lanes for lanes in LANES if runs >= 4 * lanes), LANES[-1] if 2 * runs >= LANES[-1] else 0)


def make_engine(planned: Plan, name: str, seed: int, run: int, memory: Memory) -> Engine:
    """An engine that starts from a memory."""
    if name == "python":
        return Interpreter(planned, seed, run, memory.copy())
    if name == "cxxrtl":
        from proofmass.runner.rtl.co_simulation import CoSimulation

        return CoSimulation(planned, seed, run, memory)
    from proofmass.runner.engine.native import CompiledLoop

    return CompiledLoop(planned, seed, run, memory)
