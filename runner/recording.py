"""Recorded signals: CSV, Parquet or netCDF, read into the buffers of the block that plays them."""

from proofmass.graphs.graph import Graph


def read_recordings(graph: Graph, name: str) -> dict[str, list[float]]:
    """The recorded buffers of a block, by name; empty for a block that plays no recording."""
    return {}
