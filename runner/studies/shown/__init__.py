"""Tables, pictures and reports of a study."""
