"""What a study is: spread, drift, sweeps, epochs and limits, and its files."""
