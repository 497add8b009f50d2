"""Worst cases of quantities within tolerances."""
