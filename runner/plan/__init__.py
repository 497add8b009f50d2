"""The plan: everything that is known before the first tick, and the memory that moves."""
