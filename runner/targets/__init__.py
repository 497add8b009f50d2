"""Machine code of a tick loop, for one run or several side by side."""
