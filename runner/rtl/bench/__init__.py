"""Test benches, vectors, costs and the report of hardware."""
