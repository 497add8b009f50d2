"""Limits of graphs and files, the form of a name, and limits of a TOML text before it is parsed."""

import re

NAME = re.compile(r"(?=.{1,64}$)[a-z][a-z0-9]*(_[a-z0-9]+)*")
EXPECTED_NAME = "at most 64 lower-case letters and digits, words joined by single underscores"

FILE_BYTES = 1 << 20
WORDS = 100_000  # names, numbers, texts and marks of a file
ESCAPES = 100_000  # backslashes of a file: the parser's time grows faster than their number
NESTING = 32
DEPTH = 15  # subgraphs inside each other
KEY_PARTS = 2 * DEPTH + 2  # blocks.outer.blocks.inner
KEY_LENGTH = 256  # a name, or the path of a block
NUMBER_LENGTH = 400
TEXT_LENGTH = 400  # of a text that is read as a quantity, a name or a choice
LARGEST_RUN = 10**12  # ticks
LARGEST_SEED = 2**62
LARGEST_STUDY = 2**32  # runs times epochs: a word of the counter of the noise
BLOCKS = 10_000
WIRES = 100_000
ALL_FILES_BYTES = 4 << 20  # of a graph and its subgraphs together
PROBLEMS = 100  # reported at once
