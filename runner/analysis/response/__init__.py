"""Responses of a graph from one wire to another: linear ones, and those of simulations beside them."""
