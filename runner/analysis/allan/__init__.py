"""Allan deviations, and the coefficients of noise that they show."""
