"""The runner: plans a graph, runs it in plain Python or compiled, and hands out results."""
