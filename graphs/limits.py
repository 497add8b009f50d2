"""The largest graph and file that are read, and what a TOML text looks like before it is parsed."""

FILE_BYTES = 1 << 20
WORDS = 100_000  # names, numbers, texts and marks of a file
NESTING = 32
KEY_PARTS = 8
KEY_LENGTH = 64
NUMBER_LENGTH = 400
TEXT_LENGTH = 400  # of a text that is read as a quantity, a name or a choice
BLOCKS = 10_000
WIRES = 100_000
PROBLEMS = 100  # that are reported at once
