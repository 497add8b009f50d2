"""A graph becomes a plan, and the plan runs tick by tick, in Python or compiled."""
