"""How a block is declared: parameters, ports, units, problems, and the catalogue of all blocks."""
