"""Fits of temperature models."""
