"""Cost of hardware before synthesis: multipliers, and bits of adders, comparators, multiplexers and registers."""

from collections import Counter
from dataclasses import dataclass, field
from typing import Any

from proofmass.runner.fixed.operations import OPERATIONS
from proofmass.runner.rtl.machine.low_bits import operands_of
from proofmass.runner.rtl.machine.machine import Machine
from proofmass.runner.rtl.machine.modules import Module
from proofmass.runner.rtl.machine.words import Word


@dataclass
class Cost:
    """Bits, and numbers of multipliers by the widths of their operands; constants are operands."""

    adder_bits: int = 0
    comparator_bits: int = 0
    multiplexer_bits: int = 0
    register_bits: int = 0  # of the state
    pipeline_bits: int = 0  # of registers that cuts add
    widest: int = 0  # bits of the widest value
    multipliers: Counter[tuple[int, int]] = field(default_factory=Counter)
    constant_multipliers: Counter[tuple[int, int]] = field(default_factory=Counter)

    def __add__(self, other: "Cost") -> "Cost":
        sums: dict[str, Any] = {name: own + vars(other)[name] for name, own in vars(self).items()}
        sums["widest"] = max(self.widest, other.widest)
        return Cost(**sums)

    def as_data(self) -> dict[str, Any]:
        """Plain data: multipliers as {"32 x 24": 2}."""
        data: dict[str, Any] = dict(vars(self))
        for name in ("multipliers", "constant_multipliers"):
            data[name] = {f"{a} x {b}": n for (a, b), n in sorted(data[name].items(), reverse=True)}
        return data


def module_cost(module: Module) -> Cost:
    """Cost of one module."""
    cost = Cost(register_bits=sum(register.word.width for register in module.registers))
    cost.pipeline_bits = module.pipeline.waits
    for operation in module.needed:
        cost.pipeline_bits += operation.width * (module.pipeline.delays.get(operation, 0) + (operation.kind == "pipe"))
        cost.widest = max(cost.widest, operation.width)
        widths = [operand.width for operand in operation.operands]
        if operation.kind == "input":
            continue
        if OPERATIONS[operation.kind].adder and operands_of(operation) == operation.operands:
            cost.adder_bits += operation.width
        elif OPERATIONS[operation.kind].comparison:
            cost.comparator_bits += max(widths)
        elif operation.kind == "select":
            cost.multiplexer_bits += operation.width
        elif operation.kind in ("minimum", "maximum"):
            cost.comparator_bits += max(widths)
            cost.multiplexer_bits += operation.width
        elif operation.kind == "multiply":
            known = any(operand.constant is not None for operand in operation.operands)
            shapes = cost.constant_multipliers if known else cost.multipliers
            shapes[max(widths), min(widths)] += 1
    return cost


def machine_cost(machine: Machine) -> Cost:
    """Cost of all instances, the registers of nets, and the counters of the enables."""
    stored = sum(net.word.width for net in machine.nets.values() if net.kept)
    counters = sum(Word(0, last).width for _, _, last in machine.counters)
    late = sum(net.word.width * delay for net, delay in machine.delays.items())
    late += max((each.stage for each in machine.instances if each.module.registers), default=0)
    nets = Cost(register_bits=stored + counters, pipeline_bits=late)
    return sum((module_cost(each.module) for each in machine.instances), nets)
