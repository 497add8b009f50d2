"""Signals from nowhere: constants, steps, sines, recordings, shift registers, temperatures."""
