"""What measures are made of: statistics that a loop keeps as it runs."""
