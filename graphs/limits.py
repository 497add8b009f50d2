"""The largest file that is read, and what a TOML text looks like before it is parsed."""

FILE_BYTES = 1 << 20
NESTING = 32
KEY_PARTS = 8
KEY_LENGTH = 64
DIGITS = 400
ENTRIES = 200_000
