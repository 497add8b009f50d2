"""Statistics that a loop keeps as it runs: measures are made of them."""
