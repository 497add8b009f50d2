"""Resources of the self-calibration in a Virtex-II Pro beside those that Sarraf et al. 2012 give (tables 3 and 4).

    python benchmarks/rtl_resources.py

Ours are what Yosys makes of the emitted Verilog, slices a bound; theirs are of a flow of 2012 with a block set, whose
blocks are not described to the bit. "DUT-R, all 32 bits" is a conjecture: a model made for this table, of five products
of 32 by 32 bits and one of 16 by 16, since their 21 multipliers are then ours.
"""

from pathlib import Path

from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.planning.plan import plan
from proofmass.runner.rtl.machine.compose import compose
from proofmass.runner.rtl.text.machine_verilog import machine_text, top_name
from proofmass.runner.rtl.tools.synth import Resources, synthesized

ROOT = Path(__file__).parent.parent
LIBRARY = library_file("self_calibration_fixed.toml")
GYROSCOPE = library_file("self_calibration_gyroscope_fixed.toml")
DUT_R = Path(__file__).parent / "reference_model_32_bits.toml"

ROWS = (  # block, blocks of ours, slices, flip-flops, lookup tables, multipliers of the paper, why they differ
    ("PN generator", ("chips",), (12, 11, 1, 0), "one more output register in the paper"),
    ("stiffness controller", ("stiffness",), (248, 58, 484, 0), "their constant product is made of lookup tables"),
    ("damping controller", ("damping",), (207, 99, 365, 0), "they register operands; ours multiplies by a constant"),
    ("correlation cells", ("cell", "model_cell"), (424, 127, 811, 0), "how many they have is not said; ours are two"),
    ("overall", (), (3547, 1857, 6461, 21), "no operand or pipeline registers; constants fold into the products"),
)
GYROSCOPE_ROWS = (  # table 4
    ("PN generator", ("chips",), (12, 11, 1, 0), "one more output register in the paper"),
    ("stiffness controller", ("stiffness",), (252, 58, 492, 0), "their constant product is made of lookup tables"),
    ("damping controller", ("damping",), (175, 98, 293, 0), "ours is larger: inputs of 20 bits, a gain of more digits"),
    ("correlation cells", ("cell", "model_cell"), (1694, 2536, 2827, 0), "theirs are many more; ours are two"),
    ("DUT-R", ("model",), (2533, 934, 4646, 35), "words of the library's graph; theirs are not said"),
    ("overall", (), (4686, 3646, 8275, 35), "no operand or pipeline registers; two cells"),
)


def main() -> None:
    """Print the tables."""
    print(f"{'':22}{'paper: slices/FF/LUT/MULT':>28}{'ours: slices at least/FF/LUT/MULT':>36}   why")
    for name, blocks, paper, why in ROWS:
        show(name, paper, resources(LIBRARY, blocks), why)
    why = "conjecture: the multipliers agree; the paper's registers and lookup tables are those of its flow"
    show("DUT-R, all 32 bits", (2618, 1495, 4865, 21), resources(DUT_R, ()), why)
    print("\nthe gyroscope, table 4")
    for name, blocks, paper, why in GYROSCOPE_ROWS:
        show(name, paper, resources(GYROSCOPE, blocks), why)


def resources(path: Path, blocks: tuple[str, ...]) -> Resources:
    """Of blocks of a graph, or of its whole digital part."""
    machine = compose(plan(read_graph(path), wide=True), blocks, "hardware")
    return synthesized(machine_text(machine), top_name(machine), "xc2vp")


def show(name: str, paper: tuple[int, ...], resources: Resources, why: str) -> None:
    """One row."""
    ours = (resources.slices_bound, resources.flip_flops, resources.luts, resources.multipliers)
    row = (" / ".join(map(str, each)) for each in (paper, ours))
    theirs, own = row
    clock = f"; about {resources.clock.megahertz:.1f} MHz (estimate)" if resources.clock.megahertz else ""
    print(f"{name:22}{theirs:>28}{own:>36}   {why}{clock}", flush=True)


if __name__ == "__main__":
    main()
