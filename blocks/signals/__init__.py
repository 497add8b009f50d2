"""Sums, products, gains, limits, delays and holds."""
