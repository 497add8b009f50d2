"""TOML files of graphs: read, written and edited."""
