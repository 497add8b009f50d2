"""The value Graph: blocks, wires, rates, probes, measures and loops."""
