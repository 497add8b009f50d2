"""What a graph is to be tuned for: free parameters, goals, operating points."""
