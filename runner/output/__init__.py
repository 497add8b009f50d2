"""What is written of a run: files, pictures, the report."""
