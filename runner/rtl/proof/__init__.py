"""Proofs that Verilog does what the blocks do."""
