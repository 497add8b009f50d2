"""Fixed-point steps, traced once into integers."""
