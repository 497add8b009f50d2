"""Operating points, exact period maps, and the open loops made of them."""
