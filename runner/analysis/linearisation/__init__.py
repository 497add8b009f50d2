"""Operating points, exact period maps, and open loops."""
