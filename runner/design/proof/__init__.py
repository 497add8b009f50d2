"""Proofs over tolerances."""
