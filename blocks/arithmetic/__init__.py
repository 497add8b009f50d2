"""Arithmetic that blocks share: fixed point, rounding, elementary functions, random numbers, CORDIC, pipelines."""
