"""JSON schemas of graph and study files."""
