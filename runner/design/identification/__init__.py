"""Parameters of a graph from recordings of what goes in and what comes out."""
