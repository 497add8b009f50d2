"""Formulas of named values: arithmetic with units, in a grammar of its own."""
