"""Blocks in fixed point, bit for bit what hardware does."""
