"""Outcomes of runs, statistics, intervals, results of studies."""
