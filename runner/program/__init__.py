"""The tick loop, written from a plan."""
