"""Comparison of two graphs, two runs or two studies."""
