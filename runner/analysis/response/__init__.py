"""Responses of a graph from one wire to another: linear ones, and simulated ones beside them."""
