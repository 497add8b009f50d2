"""A loop that needs its gain k: its pole is 1.1 - k, so that it is stable for 0.1 < k < 2.1, and k = 0.25."""

from proofmass.graphs.files.toml_reader import read_graph_text

LEAST, MOST, GAIN = 0.1, 2.1, 0.25
GRAPH = read_graph_text("""
rate = "1 kHz"
samples = 400
wires = ["plant.strictly_proper_part -> error.second", "error.output -> gain.input", "gain.output -> plant.input",
         "step.output -> error.first"]
probes = ["plant.output"]

[loops.main]
open_at = "error.output"

[blocks]
step = { kind = "Step" }
error = { kind = "Difference" }
gain = { kind = "Gain", gain = 0.25 }
plant = { kind = "DiscreteTransferFunction", numerator = [1.0], denominator = [1.0, -1.1] }
""")
