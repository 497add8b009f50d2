"""Quantities of a graph with their derivatives by parameters: of goals and tolerances."""
