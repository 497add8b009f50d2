"""Resources of modules after synthesis, and the rules for products with a narrow factor."""

import re
from pathlib import Path

import pytest

from proofmass.blocks import FixedProduct, ShiftRegister
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.command_line import main
from proofmass.runner.planning.plan import plan
from proofmass.runner.rtl.machine.compose import compose
from proofmass.runner.rtl.proof.smt_implementation import read_implementation
from proofmass.runner.rtl.proof.smt_solver import SmtSolver
from proofmass.runner.rtl.text.machine_verilog import machine_text, top_name
from proofmass.runner.rtl.text.verilog import module_text
from proofmass.runner.rtl.tools.narrow_products import NARROW, SWAPPED
from proofmass.runner.rtl.tools.path_delay import longest_path
from proofmass.runner.rtl.tools.synth import synthesized
from proofmass.runner.rtl.tools.yosys import run_yosys
from tests.by_hand.modules import module_of

pytest.importorskip("pyosys")

CALIBRATION = library_file("self_calibration_fixed.toml")
GYROSCOPE = library_file("self_calibration_gyroscope_fixed.toml")
REFERENCE_MODEL = Path(__file__).parents[4] / "benchmarks" / "reference_model_32_bits.toml"


@pytest.mark.exhaustive
def test_a_shift_register_is_ten_flip_flops_and_one_lookup_table() -> None:
    found = synthesized(module_text(module_of(ShiftRegister())), "block", "xc2vp")
    assert (found.flip_flops, found.luts, found.multipliers) == (10, 1, 0)
    assert found.slices_bound == 5
    assert "an estimate" in found.clock.told
    assert str(found).startswith("1 LUT, 10 FF, 0 multipliers, 0 carries, at least 5 slices; clock: ")


@pytest.mark.exhaustive  # seconds of Yosys
def test_a_product_of_32_by_32_bits_is_four_multipliers() -> None:
    wide = Fixed(32, 20)
    block = FixedProduct(first_format=wide, second_format=wide, output_format=wide)
    assert synthesized(module_text(module_of(block)), "block", "xc2vp").multipliers == 4


@pytest.mark.exhaustive  # seconds of Yosys; the shift register above stays
def test_the_reference_model_of_32_bits_takes_21_multipliers_as_published() -> None:
    """Sarraf et al. 2012, table 3: DUT-R. That all its words have 32 bits is a conjecture that its multipliers fit."""
    machine = compose(plan(read_graph(REFERENCE_MODEL), wide=True))
    found = synthesized(machine_text(machine), top_name(machine), "xc2vp")
    assert (found.flip_flops, found.multipliers) == (64, 21)
    assert found.luts == pytest.approx(1149, rel=0.05)  # of the paper's flow 4865


@pytest.mark.parametrize(
    ("blocks", "flip_flops", "luts", "multipliers"),
    [
        pytest.param(("damping",), 16, 537, 0, marks=pytest.mark.exhaustive),
        pytest.param((), 396, 2953, 23, marks=pytest.mark.exhaustive),
    ],  # of the paper 98, 293, 0; 3646, 8275, 35
)
def test_the_gyroscope_beside_the_paper(blocks: tuple[str, ...], flip_flops: int, luts: int, multipliers: int) -> None:
    """Sarraf et al. 2012, table 4: the damping controller, larger than theirs, and the overall system."""
    machine = compose(plan(read_graph(GYROSCOPE), wide=True), blocks, "hardware")
    found = synthesized(machine_text(machine), top_name(machine), "xc2vp")
    assert (found.flip_flops, found.multipliers) == (flip_flops, multipliers)
    assert found.luts == pytest.approx(luts, rel=0.05)


@pytest.mark.exhaustive("a * b", "b * a")
@pytest.mark.parametrize("product", ["a * 12'sd1471", "a * -7'sd43", "a * b", "b * a", "c * a", "c * 9'd300"])
def test_products_by_sums_are_the_products(product: str, tmp_path: Path) -> None:
    pytest.importorskip("bitwuzla")
    ports = "input signed [7:0] a, input signed [2:0] b, input [3:0] c, output signed [19:0] y"
    text = f"module m({ports});\n assign y = {product};\nendmodule\n"
    for name, content in (("m.v", text), ("narrow.v", NARROW), ("swapped.v", SWAPPED)):
        (tmp_path / name).write_text(content)
    maps = ["techmap -max_iter 1 -map swapped.v t:$mul r:A_WIDTH<5 %i", "techmap -map narrow.v t:$mul"]
    run_yosys(tmp_path, ["read_verilog m.v", "proc", "wreduce", *maps, "opt", "rename m n", "write_verilog n.v"])
    mapped = (tmp_path / "n.v").read_text()
    assert " * " not in mapped
    one, other = read_implementation(text, "m"), read_implementation(mapped, "n")
    joined = [f"(= {one.terms[name]} {other.terms[name]})" for name in "abc"]
    solver = SmtSolver([*one.lines, *other.lines])
    known = [solver.read(each) for each in joined]
    equal = solver.read(f"(= {one.terms['y']} {other.terms['y']})")
    assert solver.prove(equal, known, 20.0, {}).verdict == "proved"


@pytest.mark.exhaustive
def test_the_command_counts_and_writes_it(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    words = ["rtl", str(CALIBRATION), "--block", "chips", "-o", str(tmp_path), "--ticks", "3", "--synth", "ice40"]
    assert main(words) == 0
    assert re.search(r"shift_register: \d LUT, 10 FF, 0 multipliers", capsys.readouterr().out)
    assert '"flip_flops": 10' in (tmp_path / "report.json").read_text(encoding="utf-8")


def test_the_longest_path_is_the_sum_of_its_delays() -> None:
    def cell(kind: str, inputs: dict[str, list[int]], output: int) -> dict[str, object]:
        directions = dict.fromkeys(inputs, "input") | {"O": "output"}
        return {"type": kind, "connections": {**inputs, "O": [output]}, "port_directions": directions}

    netlist = {
        "cells": {
            "from": cell("FDRE", {"D": [9], "C": [0]}, 1),
            "first": cell("LUT2", {"I0": [1], "I1": [8]}, 2),
            "carry": cell("MUXCY", {"S": [2], "CI": [7]}, 3),
            "next": cell("MUXCY", {"S": [6], "CI": [3]}, 4),
            "to": cell("FDRE", {"D": [4], "C": [0]}, 5),
        },
        "ports": {"y": {"direction": "output", "bits": [5, "0"]}},
    }
    # clock to output, wire, table, into the chain beside it, along the chain, wire, set-up
    assert longest_path(netlist) == pytest.approx(0.45 + 0.75 + 0.37 + 0.41 + 0.05 + 0.75 + 0.35)
    assert re.match(r"\d", str(longest_path({"cells": {}, "ports": {}})))
