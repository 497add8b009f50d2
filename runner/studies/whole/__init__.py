"""Studies from their first run to their last."""
