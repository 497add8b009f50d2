"""Parameters that meet goals."""
