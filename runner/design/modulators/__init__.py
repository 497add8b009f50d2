"""Design of sigma-delta modulators: noise transfer function, loop filter, prediction, graph."""
