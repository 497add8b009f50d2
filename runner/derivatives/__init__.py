"""Exact derivatives by dual numbers."""
