"""Oscillators under control."""
