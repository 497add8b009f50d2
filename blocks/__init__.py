"""Blocks: one file per block, pure functions over scalars, the standard library only."""
