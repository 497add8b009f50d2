"""The reference engine: plain Python."""
