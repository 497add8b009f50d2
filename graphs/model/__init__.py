"""What a graph is: blocks, wires, rates, probes, measures and loops."""
