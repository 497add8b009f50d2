"""What each run of a study draws."""
