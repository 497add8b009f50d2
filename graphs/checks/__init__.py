"""Checks of a graph before it runs, and the order in which its functions run."""
