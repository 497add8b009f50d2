"""The value Tuning: free parameters, goals and operating points."""
