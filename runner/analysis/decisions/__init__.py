"""Decisions of quantisers with few levels in a run: their gain for small signals, and the spectrum of their error."""
