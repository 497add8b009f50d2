"""Random parameters of the runs of a study."""
