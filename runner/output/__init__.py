"""Files, pictures and reports of runs."""
