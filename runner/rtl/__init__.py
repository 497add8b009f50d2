"""Hardware from traced steps: Verilog of the digital part of a graph."""
