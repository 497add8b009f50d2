"""Commands: one file each; declarations, answers and texts that they share."""
