"""Chunks of runs on threads and on workers of a cluster."""
