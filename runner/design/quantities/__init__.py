"""Quantities of a graph with their derivatives by parameters: what goals and tolerances are about."""
