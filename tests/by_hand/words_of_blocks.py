"""Names that attributes of blocks or of their kinds have or had: parameters and ports may have them."""

WORDS_OF_BLOCKS = (
    "buffers", "constants", "constants_class", "continuous", "corner", "corners", "derivative", "digital", "drivable",
    "event", "events", "feedthrough", "format_of", "formats", "functions", "inputs", "linear", "mro", "output",
    "output_functions", "outputs", "parameters", "parameters_class", "requirements", "requires", "shape_of", "size",
    "start", "state_class", "taken_in_the_loop", "unit_of", "update",
)  # fmt: skip
OF_OUTPUTS = tuple(word for word in WORDS_OF_BLOCKS if word not in ("derivative", "update"))
