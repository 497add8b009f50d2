"""A graph linearised at its operating point, and the margins of its loops."""
