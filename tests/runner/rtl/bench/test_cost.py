"""Bits of adders, registers and multipliers, counted by hand."""

from proofmass.blocks import FixedCorrelationCell, FixedMassSpringDamper, ShiftRegister
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.runner.rtl.bench.cost import machine_cost, module_cost
from tests.by_hand.machines import loop_at_rates, made
from tests.by_hand.modules import module_of


def test_registers_are_those_of_the_paper() -> None:
    """Sarraf et al. 2012, table 3: ten cells, and in a correlation cell 16 bits and the order, a counter, a chip."""
    assert module_cost(module_of(ShiftRegister())).register_bits == 10
    assert module_cost(module_of(FixedCorrelationCell(lag=4))).register_bits == (16 + 10) + 10 + 16 + 4 * 2


def test_multipliers_of_the_reference_model() -> None:
    cost = module_cost(module_of(FixedMassSpringDamper()))
    assert cost.multipliers == {(32, 24): 2}  # by c/m and k/m
    assert sum(cost.constant_multipliers.values()) == 2  # by the step
    wide = dict.fromkeys(("large_format", "damping_format", "small_format", "step_format"), Fixed(32, 24))
    assert module_cost(module_of(FixedMassSpringDamper(**wide))).multipliers == {(32, 32): 2}


def test_a_machine_has_the_bits_of_its_blocks_nets_and_counters() -> None:
    machine, _ = made(loop_at_rates(), clocks=1)
    blocks = [module_cost(each.module) for each in machine.instances]
    kept = sum(net.word.width for net in machine.nets.values() if net.kept)
    counters = 1 + 2  # 0 to 1 and 0 to 2
    cost = machine_cost(machine)
    assert cost.register_bits == sum(each.register_bits for each in blocks) + kept + counters
    assert cost.adder_bits == sum(each.adder_bits for each in blocks)
    assert cost.as_data()["constant_multipliers"] == {
        f"{a} x {b}": n for each in blocks for (a, b), n in each.constant_multipliers.items()
    }
