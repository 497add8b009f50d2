"""The digital part of a graph as a machine of registers and operations."""
