"""Noise and slow change: white, flicker, random walk, ageing."""
