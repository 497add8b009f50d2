"""Models of temperature and their compensation."""
