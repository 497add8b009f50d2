"""Compiled models of hardware inside the tick loop."""
