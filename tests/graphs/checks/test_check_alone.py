"""Reading and checking a graph, as a process of its own: quick, and without the libraries that only a run needs."""

import json
import resource
import subprocess
import sys
from pathlib import Path

from proofmass.blocks.declaration.catalog import all_blocks

COUNTED = "for number in range(20_000_000): pass"  # takes about half a second; the limit, whatever the machine
HEAVY = {"numpy", "numba", "llvmlite", "scipy", "control", "pint", "matplotlib", "xarray", "click", "jsonschema"}
PROGRAM = """
import json, sys
from proofmass.graphs.checks.check import check
from proofmass.graphs.files.toml_reader import read_graph
problems = check(read_graph(sys.argv[1]))
print(json.dumps({"problems": len(problems), "modules": sorted({name.split(".")[0] for name in sys.modules}),
                  "blocks": sorted(name for name in sys.modules if name.startswith("proofmass.blocks."))}))
"""


def twenty_blocks() -> str:
    """A chain of twenty blocks of ten kinds."""
    kinds = [
        "Gain",
        "UnitDelay",
        "Negation",
        "LowPass",
        "Saturation",
        "Decimator",
        "Sum",
        "Difference",
        "Product",
        "Gain",
    ]
    available = all_blocks()
    chain = [kind for kind in kinds if kind in available] * 2
    text, wires, last = 'name = "twenty"\nrate = "10 kHz"\nduration = "1 s"\n', [], "source.output"
    blocks = '[blocks.source]\nkind = "Sine"\n'
    for number, kind in enumerate(chain):
        blocks += f'[blocks.b{number}]\nkind = "{kind}"\n'
        required = [name for name, port in available[kind].inputs.items() if port.default is None]
        wires += [f"{last} -> b{number}.{name}" for name in required]
        last = f"b{number}.{next(iter(available[kind].outputs))}"
    return f"{text}wires = {json.dumps(wires)}\nprobes = [{json.dumps(last)}]\n{blocks}"


def seconds_of(*arguments: str) -> tuple[float, str]:
    """What a process of Python takes of the processor, its start included, and what it prints."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([sys.executable, "-c", *arguments], capture_output=True, text=True, check=True, timeout=60)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, done.stdout


def test_twenty_blocks_are_checked_within_half_a_second_and_without_heavy_libraries(tmp_path: Path) -> None:
    file = tmp_path / "twenty.toml"
    file.write_text(twenty_blocks(), encoding="utf-8")
    shares = list[float]()
    # The first may have to compile the sources; beside other work a processor may be half as fast for seconds.
    while not shares or (min(shares) >= 1.0 and len(shares) < 8):
        taken, printed = seconds_of(PROGRAM, str(file))
        shares.append(taken / seconds_of(COUNTED)[0])
    said = json.loads(printed)
    assert said["problems"] == 0
    assert HEAVY.isdisjoint(said["modules"])
    assert "proofmass.blocks.control.pid" not in said["blocks"]  # only the kinds of the file are imported
    assert min(shares) < 1.0
