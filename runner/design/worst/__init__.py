"""How bad quantities can get within tolerances."""
