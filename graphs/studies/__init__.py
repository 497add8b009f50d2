"""The value Study: spread, drift, sweeps, epochs and limits; and its files."""
