"""Runs that fail: the tick in which a number stopped being finite, and the fault in the words of the graph."""

import sys
import traceback
from pathlib import Path
from typing import Any

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.problem import Problem
from proofmass.blocks.language.forms import is_own
from proofmass.graphs.model.graph import split
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan
from proofmass.runner.reference.advance import IntegrationError
from proofmass.runner.reference.interpret import Interpreter, OutOfBoundsError, TickError
from proofmass.runner.run.engines import make_engine
from proofmass.runner.run.recorder import room

NAMED_TICKS = 64  # run again in plain Python to name the one in which a number stopped being finite


class RunError(RuntimeError):
    """A run that failed; `problem` says block, port, tick and time.

    >>> from proofmass import Graph, RunError, simulate
    >>> from proofmass.blocks import Gain, Ramp
    >>> graph = Graph(
    ...     name="beyond all numbers",
    ...     rate="1 Hz",
    ...     blocks={"ramp": Ramp(slope=1e300), "gain": Gain(gain=1e10)},
    ...     wires=["ramp.output -> gain.input"],
    ...     probes=["gain.output"],
    ... )
    >>> try:
    ...     simulate(graph, samples=5)
    ... except RunError as error:
    ...     print(error.problem.key)
    gain.output
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        super().__init__(str(problem))


def name_fault(planned: Plan, seed: int, run: int, memory: Memory, end: int) -> None:
    """Raise the `TickError` before the tick `end`: the compiled loop only says there may be one.

    The ticks are halved until few are left, and plain Python goes on from there. It finds nothing
    where only the sum by which the loop watches its wires went beyond 1e308: then all is well.
    """

    last = end
    while last - memory.tick > NAMED_TICKS:
        middle = (memory.tick + last) // 2
        engine = make_engine(planned, "compiled", seed, run, memory, end)
        if engine.advance(middle, room(planned, memory.tick, middle)):
            memory = engine.memory()
        else:
            last = middle
    Interpreter(planned, seed, run, memory).advance(end, room(planned, memory.tick, end))


def failed(planned: Plan, fault: TickError) -> Problem:
    """A fault in the words of the graph: block and port, tick and time, what to look at."""
    name, port = split(fault.at)
    at = f"in tick {fault.tick}, t = {float(fault.tick / planned.schedule.base_rate):.9g} s"
    drivers = planned.schedule.drivers
    block = planned.blocks.get(name)
    ports = [*type(block).inputs, *type(block).parameters] if block else []
    inputs = [f"{port} = {'.'.join(drivers[name, port])}" for port in ports if (name, port) in drivers]
    hint = "the loop may be unstable, or a parameter of the wrong size"
    if isinstance(fault.value, IntegrationError) and fault.value.hint:
        hint = fault.value.hint
    if isinstance(fault.value, OverflowError):
        hint = "take a wider format, or let it saturate or wrap"
    own = own_line(block, fault.value)
    if own:
        hint = f"{own} raises it"
    expected = ""
    no_value = type(block).outputs[port].no_value if block and port in type(block).outputs else ""
    if no_value and fault.value != fault.value:
        message, got, hint = f"has no value {at}", "nan", no_value
    elif isinstance(fault.value, OutOfBoundsError) and block:
        declared = type(block).parameters[port]
        unit = unit_of(block, declared)
        message, got, expected = f"leaves its bounds {at}", f"{fault.value} {unit}", declared.expected(unit)
        hint = f"limit what drives it, {'.'.join(drivers[name, port])}, for example by a Saturation"
    elif isinstance(fault.value, Exception):
        message, got = f"failed {at}", f"{type(fault.value).__name__}: {fault.value}"
    else:
        message, got = f"is not finite {at}", str(fault.value)
    problem = Problem(
        message=message,
        key=fault.at,
        got=got,
        expected=expected,
        hint=hint + (f"; probe what drives it: {', '.join(inputs)}" if inputs else ""),
        path=("blocks", name),
    )
    return planned.graph.placed(problem)


def own_line(block: Block | None, error: Any) -> str:
    """File and line of a user's own block that raised an error; empty where it was not one."""
    if block is None or not isinstance(error, Exception) or not is_own(type(block)):
        return ""
    frames = traceback.extract_tb(error.__traceback__)
    module = Path(str(getattr(sys.modules.get(type(block).__module__), "__file__", "")))
    lines = [frame.lineno for frame in frames if Path(frame.filename) == module]
    return f"{module.name}:{lines[-1]}" if lines else ""
