"""Continuous blocks that are wired together, integrated together."""
