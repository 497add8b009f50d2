"""Pages that carry the engine: the loop as WebAssembly, with a field for each parameter."""
