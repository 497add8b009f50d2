"""One run: engines, checkpoints, faults, results and provenance."""
