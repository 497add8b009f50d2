"""Temperature laws fitted to measured or simulated cycles."""
