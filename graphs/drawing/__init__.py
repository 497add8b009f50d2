"""Diagrams of graphs as SVG."""
