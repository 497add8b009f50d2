"""Graphs: blocks wired by ports, read from TOML or Python, checked and scheduled."""
