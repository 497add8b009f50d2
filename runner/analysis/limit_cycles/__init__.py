"""Relays and quantisers: describing functions and limit cycles."""
