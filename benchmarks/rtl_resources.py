"""Resources of the self-calibration in a Virtex-II Pro beside those that Sarraf et al. 2012 give (tables 3 and 4).

    python benchmarks/rtl_resources.py

Ours are what Yosys makes of the emitted Verilog, slices a bound; theirs are of a flow of 2012 with a block set, whose
blocks are not described to the bit. "DUT-R, all 32 bits" has five products of 32 by 32 bits and one of 16 by 16.
"""

import tempfile
from pathlib import Path

from proofmass.graphs.toml_reader import read_graph
from proofmass.runner.engine.plan import plan
from proofmass.runner.rtl.compose import compose
from proofmass.runner.rtl.machine_verilog import machine_text, top_name
from proofmass.runner.rtl.synth import Resources, synthesized

ROOT = Path(__file__).parent.parent
LIBRARY = ROOT / "graphs" / "library" / "self_calibration_fixed.toml"
DUT_R = """
name = "reference model, all 32 bits"
rate = "2.4576 MHz"
samples = 1
wires = [
    "one.output -> force.input", "k.output -> stiffness.input", "c.output -> damping.input",
    "force.output -> over_mass.input", "over_mass.output -> model.acceleration",
    "stiffness.output -> model.stiffness", "damping.output -> model.damping",
    "model.displacement -> cut.input", "cut.output -> gain.input",
]
probes = ["gain.output"]
[blocks]
one = { kind = "Constant", unit = "uN" }
k = { kind = "Constant", unit = "1/ms^2" }
c = { kind = "Constant", unit = "1/ms" }
force = { kind = "FixedQuantiser", output_format = "(32, 24)", unit = "uN" }
stiffness = { kind = "FixedQuantiser", output_format = "(32, 20)", unit = "1/ms^2" }
damping = { kind = "FixedQuantiser", output_format = "(32, 20)", unit = "1/ms" }
over_mass = { kind = "FixedGain", gain = "19.829467 (um/ms^2)/uN", input_format = "(32, 24)", gain_format = "(32, 26)", output_format = "(32, 20)", input_unit = "uN", output_unit = "um/ms^2" }
model = { kind = "FixedMassSpringDamper", large_format = "(32, 20)", step_format = "(32, 40)" }
cut = { kind = "FixedCast", input_format = "(32, 30)", output_format = "(16, 14)", unit = "um" }
gain = { kind = "FixedGain", gain = "353.01 V/um", input_format = "(16, 14)", gain_format = "(16, 6)", output_format = "(16, 12)", input_unit = "um", output_unit = "V" }
"""

ROWS = (  # block, blocks of ours, slices, flip-flops, lookup tables, multipliers of the paper, why they differ
    ("PN generator", ("chips",), (12, 11, 1, 0), "one more output register in the paper"),
    ("stiffness controller", ("stiffness",), (248, 58, 484, 0), "their constant product is made of lookup tables"),
    ("damping controller", ("damping",), (207, 99, 365, 0), "they register operands; ours multiplies by a constant"),
    ("correlation cells", ("cell", "model_cell"), (424, 127, 811, 0), "how many they have is not said; ours are two"),
    ("overall", (), (3547, 1857, 6461, 21), "no operand or pipeline registers; constants fold into the products"),
)


def main() -> None:
    """Print the table."""
    print(f"{'':22}{'paper: slices/FF/LUT/MULT':>28}{'ours: slices at least/FF/LUT/MULT':>36}   why")
    for name, blocks, paper, why in ROWS:
        show(name, paper, resources(LIBRARY, blocks), why)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "dut_r.toml"
        path.write_text(DUT_R)
        why = "the multipliers agree; the paper's registers and lookup tables are those of its flow"
        show("DUT-R, all 32 bits", (2618, 1495, 4865, 21), resources(path, ()), why)


def resources(path: Path, blocks: tuple[str, ...]) -> Resources:
    """Of blocks of a graph, or of its whole digital part."""
    machine = compose(plan(read_graph(path), wide=True), blocks, "hardware")
    return synthesized(machine_text(machine), top_name(machine), "xc2vp")


def show(name: str, paper: tuple[int, ...], found: Resources, why: str) -> None:
    """One row."""
    ours = (found.slices_bound, found.flip_flops, found.luts, found.multipliers)
    row = (" / ".join(map(str, each)) for each in (paper, ours))
    theirs, own = row
    clock = f"; about {found.clock_mhz:.1f} MHz (estimate)" if found.clock_mhz else ""
    print(f"{name:22}{theirs:>28}{own:>36}   {why}{clock}", flush=True)


if __name__ == "__main__":
    main()
