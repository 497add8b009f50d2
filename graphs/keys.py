"""The keys of a graph file and what they mean: what the reader takes, the schema describes and hints name."""

TOP_KEYS = {
    "name": "Name of the graph, in plots and reports.",
    "description": "What the graph is, in a few lines.",
    "rate": 'Rate of every block that has none of its own: "50 kHz", or the period "20 us", or a number in hertz.',
    "duration": 'How long a run lasts when nothing else is said: "20 s", or a number in seconds.',
    "samples": "How many ticks of the base rate a run lasts, instead of a duration.",
    "seed": "Seed of the noise when nothing else is said.",
    "wires": 'Wires, "block.output -> block.input"; a wire to a parameter drives the parameter.',
    "probes": 'Outputs to record, "block.output"; { signal = "block.output", every = 10 } keeps one value in ten.',
    "exports": 'Ports and parameters that the graph has as a part of others: a name for each, as in code = "adc.code".',
    "integration": "How continuous blocks are integrated between ticks: method, accuracy, events.",
    "loops": "Control loops: [loops.NAME] with open_at, and the margins that it must have.",
    "blocks": "The blocks: [blocks.NAME] with a kind and the parameters of that kind, or with a graph.",
}
BLOCK_KEYS = {  # of every block, beside its parameters
    "kind": "Kind of the block; `proofmass blocks` lists them.",
    "rate": "Rate of this block, where it differs from the graph's.",
}
PART_KEYS = {  # of a block that is a graph, beside parameters inside it
    "graph": 'File of the graph, in the same folder or below it, or "library:NAME.toml" for one that comes along.',
    "rate": "Rate of the blocks inside that have none of their own.",
    "count": "How many there are, named NAME_1, NAME_2 and so on.",
}
LOOP_KEYS = {
    "open_at": "Output at which the loop is opened: all of the loop goes through it.",
    "gain_margin": 'Least factor, as "6 dB", by which the gain may rise or fall before the loop is unstable.',
    "phase_margin": 'Least phase, as "30 deg", that makes the loop unstable.',
    "delay_margin": 'Least delay, as "100 us", that makes the loop unstable.',
    "sensitivity_peak": 'Largest amplification of a disturbance, as "6 dB".',
}
