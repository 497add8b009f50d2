"""What comes out of the runs of a study."""
