"""Answers from a graph without a run of its own: linearisation, margins, limit cycles."""
