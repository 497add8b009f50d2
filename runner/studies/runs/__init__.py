"""Runs of a study, one by one or side by side."""
