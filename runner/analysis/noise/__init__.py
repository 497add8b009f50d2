"""Noise budgets: what each source does to an output, from the linear map of a period."""
