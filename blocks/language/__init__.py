"""The part of Python in which a block's functions are written, with the one meaning that all engines give it."""
