"""Bridges, amplifiers, switches and sensors of a readout."""
