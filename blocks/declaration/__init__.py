"""Declarations of blocks: parameters, ports, units, problems, and the catalogue of all blocks."""
