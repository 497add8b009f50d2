"""Controllers in floating point."""
