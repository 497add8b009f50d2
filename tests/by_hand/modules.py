"""Blocks as modules without a graph, and their functions on Python integers, step by step."""

from collections.abc import Mapping
from typing import Any

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import shape_of
from proofmass.runner.fixed.digital import digital_block
from proofmass.runner.fixed.step_formats import filled, mantissas, reference_step
from proofmass.runner.plan.constants import constants_of, start_of
from proofmass.runner.rtl.machine.modules import Module, make_module
from proofmass.runner.rtl.machine.words import Word

PERIOD = 1.0 / 4800.0


def module_of(block: Block, ranges: Mapping[str, Word] | None = None, period: float = PERIOD) -> Module:
    """The module of a block, as a graph would make it."""
    constants: Any = block
    if "constants" in type(block).functions:
        constants = type(block).functions["constants"].function(block, period)
    if type(block).has_formats():
        made = digital_block("block", block, period, wide=True)
        return make_module("block", block, constants, made.start, made.buffers, {})
    buffers: dict[str, list[Any]] = {name: [0] * shape_of(block, b)[0] for name, b in type(block).buffers.items()}
    constants_of(block, block, period)
    return make_module("block", block, constants, start_of(block, buffers, period), buffers, ranges or {})


class Reference:
    """The functions of a module's block on raw numbers: what plain Python does."""

    def __init__(self, module: Module) -> None:
        self.module = module
        self.held = {register.text: register.start for register in module.registers}

    def tick(self, inputs: Mapping[str, int]) -> dict[str, int]:
        """The outputs, by the names of the ports; then the state moves."""
        module = self.module
        known = {**self.held, **{port.text: inputs[port.name] for port in module.inputs}}
        outputs: dict[str, int] = {}
        following: dict[str, int] = {}
        for name, traced in module.steps.items():
            functions = {**type(module.block).output_functions, **type(module.block).functions}
            step = reference_step(functions[name].function, traced.formats)
            given = {
                argument: filled(traced.formats[argument], argument, lambda text, format: known.get(text, 0))
                for argument in traced.arguments
            }
            result = step(*given.values())
            if name == "update":
                following |= dict(mantissas(traced.formats["return"], result, "x"))
                for buffer in type(module.block).buffers:
                    if buffer in given:
                        following |= dict(mantissas(traced.formats[buffer], given[buffer], buffer))
            elif "out" in given:
                found = dict(mantissas(traced.formats["out"], given["out"], name))
                outputs |= {port.name: int(found[port.text]) for port in module.outputs if port.text in found}
            else:
                outputs |= {port.name: int(result) for port in module.outputs if port.text == name}
        self.held |= {text: int(following[text]) for text in self.held if text in following}
        return outputs
