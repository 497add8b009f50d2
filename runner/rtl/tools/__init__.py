"""Programs of others: Yosys, nextpnr, simulators."""
