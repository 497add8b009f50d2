"""Margins of several loops at once, and of loops over temperature, age or any other parameter."""
