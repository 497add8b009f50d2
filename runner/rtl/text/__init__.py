"""A machine as Verilog and Amaranth."""
