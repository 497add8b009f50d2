"""Explanations of faults: for each kind a code, the messages that belong to it, its cause and its cure.

`proofmass explain` prints an entry, and the documentation has a page of all. A message belongs to the first entry
with a pattern that is found in it.
"""

import re
from functools import lru_cache
from typing import NamedTuple


class Explanation(NamedTuple):
    """One kind of fault."""

    code: str
    title: str
    messages: str  # a pattern of messages
    cause: str
    cure: str


EXPLANATIONS = (
    Explanation(
        "P0101",
        "The file is not TOML",
        r"not TOML|not UTF-8|NUL character|half a character|over \d+ (levels|parts|digits)|too many brackets",
        "The text breaks a rule of TOML: texts and quantities have straight quotes, a comment begins with #, "
        "lists have commas.",
        'Write the line as in kind = "Gain" or mass = "50 ug". The hint shows the line as it was probably meant.',
    ),
    Explanation(
        "P0102",
        "A file cannot be read",
        r"cannot be read|there is no (such )?file|is not a file|outside the folder|contains itself|larger than"
        r"|file is too large|has no file|name of a file|no such column|has no column|holds no (list of )?values"
        r"|recording|not a number$|cannot be compared|holds no (whole )?run|holds no study|no folder of this study"
        r"|too few rows|in row|time does not grow|there is no block in the file|edited in place|says no file"
        r"|no such graph|cells where|holds (one|no) rows?|columns? |is not (a )?CSV|time axis|equally spaced"
        r"|no variable"
        r"|not a finite number|columns look|of its columns|^the certificate |values are left"
        r"|not of one length|complex numbers|no times along|holds (\d+|\{\}) rows"
        r"|misses (\d|\{\})|has (\d+ gap|\{\}$)|its first time|file of blocks|of a block raises",
        "A file that is named is not there, is of another kind, or lies where a graph may not look: graphs name "
        "files in their own folder or below it.",
        "Correct the name, or put the file beside the graph. A graph that comes along is library:NAME.",
    ),
    Explanation(
        "P0201",
        "There is no such kind of block",
        r"no such kind of block|^a block needs a kind|^not a block|^is not a block$|library has a block of this name",
        "The kind is misspelt, is called otherwise here, or is a block of your own that was not brought along.",
        "`proofmass blocks --find WORDS` searches all kinds. Blocks of your own need --blocks FILE.",
    ),
    Explanation(
        "P0202",
        "A block has no such parameter",
        r"no such parameter|has no parameter|parameters cannot be read|has no entry",
        "The key is misspelt, is a port, or stands below the wrong [blocks.NAME].",
        "`proofmass blocks KIND` lists the parameters. Inputs are wired, outputs are probed.",
    ),
    Explanation(
        "P0203",
        "A table has no such key",
        r"unknown key|^has no \{?\w*\}?$|has no \w+$|given twice|named twice|needs? (one|a|the|an) "
        r"|stands in the wrong table|is a study, not a graph|this is not a graph$"
        r"|the study names no graph|is named by|has a graph and|needs \w+$|needs \w+ and|must name (one"
        r"|a measure)|needs \{\}|asks nothing"
        r"|names no|must say|which signal is meant|no table|has no study",
        "A key of the file or of a table in it is unknown, missing, or given twice.",
        "docs/graph-files.md lists all keys; `proofmass schema` writes a schema by which editors complete them.",
    ),
    Explanation(
        "P0204",
        "A name is not one",
        r"^not a name|^not an id|name is taken|another block of that name|nothing can be added inside"
        r"|measure of that name",
        "Names are lower-case letters and digits, words joined by single underscores, and some names are taken.",
        "Write read_out instead of ReadOut, and give two blocks two names.",
    ),
    Explanation(
        "P0205",
        "Something that is named is not there",
        r"there is no |there is nothing|no such|is not one of the choices|is neither an? (input|port)"
        r"|is an (input|output), not|is a (parameter|value|block|port), not|is a value:|a block without"
        r"|is not a (signal|parameter)|not an? (wire|probe|output|port)|is not exported|exports no such"
        r"|no wire begins"
        r"|not a level",
        "A wire, probe, measure or option names a block, port, value or choice that does not exist.",
        "The hint has the nearest name, or all that there are. A signal is written block.output.",
    ),
    Explanation(
        "P0301",
        "A unit cannot be read",
        r"unknown unit|read the unit|^an empty unit|a unit (of|with|beyond|is missing)|unit ends too early"
        r"|an exponent|decimal comma|a minus sign|a bracket is not closed|dimension with an exponent"
        r"|the quantity .* ends|not a number followed by a unit|division by zero|exponent of|has a unit with",
        "A quantity is a number and a unit in quotes, and the unit is unknown or misspelt.",
        'Write "5.1 nV/sqrt(Hz)", "9.81 m/s^2", "3 g0" for three times standard gravity, "298.15 K" for 25 '
        "degrees Celsius.",
    ),
    Explanation(
        "P0302",
        "A quantity of another dimension",
        r" is \S+, not |in decibels|is \{\}, not|takes a plain number|takes \S+ and |has another unit"
        r"|values are not relative|cannot be shown in",
        "The unit measures another quantity: a mass is not an acceleration.",
        "Give it in the unit that the message expects. g is the gram; standard gravity is g0.",
    ),
    Explanation(
        "P0303",
        "A value is out of its bounds",
        r"out of range|must be (>|<|at |above |finite|two )|must (lie|not be|ascend|differ|suit|hold)|must be \{\}"
        r"|too (large|small|long|many)|beyond 62 bits|too large for|longer than|over \{\}|has more than|too cold"
        r"|leaves no room|nested deeper|range|must not|bounds|logarithmic axis|no upper end|nothing can meet"
        r"|is soft|is not a tolerance|is not a limit|is bounded already|at least 1|are larger"
        r"|all hard goals|is not a rate (of change|above zero)|no worst value|in the yield already|has the ages of",
        "A number is smaller or larger than its parameter allows, or a file holds more than a limit.",
        "The message has the bounds. `proofmass blocks KIND` has those of a block.",
    ),
    Explanation(
        "P0304",
        "A value of another type",
        r"must be |must yield|the same type|is not a (number|linear system)|half of|give samples or duration",
        "An integer, a text, a list or a table is wanted, and something else was given.",
        "Integers are written without a point; texts and quantities have quotes; lists have square brackets.",
    ),
    Explanation(
        "P0305",
        "A formula cannot be read or computed",
        r"a formula|formula |no function|no finite value|stands outside the brackets|an operator is missing"
        r"|name is missing|bracket (is|of)|takes \S+ argument|holds a number|no texts|no value or unit"
        r"|does not hold the value|depends on itself",
        "A text that begins with = is a formula of named values and numbers with units, and this one is not right.",
        'Write weight = "= mass * 9.81 m/s^2" below [values], and use it as in "= weight".',
    ),
    Explanation(
        "P0306",
        "Parameters do not go together",
        r"go with the other parameters|go together|not both|block does not take|constants cannot be computed"
        r"|go with it|several inputs or outputs|only numbers|more zeros|is of (order|discrete)|a direct part"
        r"|for a time step",
        "Each value may be right alone, but a block cannot have all of them at once.",
        "The message says what is expected of one in view of the others.",
    ),
    Explanation(
        "P0401",
        "Two ends of a wire have different units",
        r"the units (do not match|differ|cannot be compared)",
        "Nothing is converted in silence: both ends of a wire measure the same quantity in the same unit.",
        "Change one of the units, or put a Gain between, with input_unit and output_unit.",
    ),
    Explanation(
        "P0402",
        "Two ends of a wire have different types, shapes or formats",
        r"the (types|shapes|formats) do not match|a vector cannot|fixed-point value cannot",
        "A code is not a number, a vector is not a single value, and fixed-point formats differ in their bits.",
        "Take another output of the block, or put a converter between: AnalogToDigital, VectorElement, FixedCast.",
    ),
    Explanation(
        "P0403",
        "An input has no wire, or two",
        r"is not connected|is backwards|is driven twice|is driven by|cannot be driven|is exported (twice|and)"
        r"|exported input|probed twice",
        "Every input without a default needs exactly one wire. Parameters that fix a size or a start take none.",
        "Add the wire that the hint proposes, remove one of two, or add signals by a Sum.",
    ),
    Explanation(
        "P0404",
        "An algebraic loop",
        r"algebraic loop|within the same tick|Newton's method",
        "In a ring of blocks each needs the value of the one before it in the same tick, so none can be computed "
        "first.",
        'Put a UnitDelay into the ring, or let it be solved: algebraic_loops = "solve" under [integration].',
    ),
    Explanation(
        "P0405",
        "Something is not used or not recorded",
        r"none of its (exported )?outputs|no probes|records nothing|nothing to record|the graph has no blocks"
        r"|nothing uses|nothing follows",
        "A block whose outputs nothing reads, or a run without probes, does no harm and has no effect.",
        "Wire or probe an output, or remove the block.",
    ),
    Explanation(
        "P0501",
        "Rates do not go together",
        r"no common base rate|base rate of a run|clock offset|no rate|continuous block has no rate"
        r"|reads the same value"
        r"|of its values is read|switches after|sampled before the switch|at several rates|tick together too rarely",
        "Discrete blocks tick at rates whose ratios are those of small integers; continuous blocks have none.",
        "Say rate at the top of the file, and at blocks that are slower. docs/explanation/ticks-and-rates.md says"
        " more.",
    ),
    Explanation(
        "P0502",
        "A run is too short, or of no stated length",
        r"how long|over after the tick at time 0|run ends before|is too short|short|no averaging time"
        r"|no relative error|no value before|ends before it",
        "The duration is shorter than what is measured, or nothing says how long to run.",
        'Say duration = "2 s" in the file, or --duration "2 s".',
    ),
    Explanation(
        "P0503",
        "A frequency is above half the rate",
        r"(not below|above) half the rate",
        "A sampled sine above half the rate has the values of a slower one, and no block can tell.",
        "Raise the rate of the graph or of the block.",
    ),
    Explanation(
        "P0504",
        "A tick takes very many steps",
        r"a tick takes",
        "A continuous group is stepped thousands of times a tick, since it is stiff or a parameter is far off.",
        'Choose method = "radau" under [integration], a lower accuracy or a higher rate.',
    ),
    Explanation(
        "P0601",
        "A study cannot be run as it is",
        r"runs? are|no law follows|the mission|calibrates|needs phases|(no|not a) history|one column|epoch|correlation$"
        r"|drift|ageing"
        r"|distribution|correlated|calibration|vary|swept|sweep|sensor can|too (old|large)|number that may vary"
        r"|the block works in fixed point|independent parameters|coefficient|no measures|equally many"
        r"|the last age|nothing varies|leaves nothing free|hardly moves|has no tolerance|that change at will"
        r"|the correlations|follows from it, and|no limit|the study has variants",
        "The tables of a study name parameters that may vary, how, and which measures count.",
        'docs/studies.md shows each table with an example. Keys of parameters are quoted: "adc.reference".',
    ),
    Explanation(
        "P0701",
        "A graph cannot be linearised there, or has no such loop",
        r"linearis|loop|periodic|stimulus|operating point|settle|perturbations|derivative|does not come back"
        r"|does not move|for margins|^the way (from|of noise)|that of a run: this|changes after the start"
        r"|of rest|reads the time|constant (value|here)|describing function|is not a gain|another output that is read",
        "Margins, noise and responses are those of a loop that is opened at a wire, about a point where the graph"
        " rests.",
        'Name a loop with [loops.main] open_at = "dac.voltage", or choose another operating point by --at.',
    ),
    Explanation(
        "P0702",
        "A signal does not suit the analysis",
        r"spectrum|Allan|tone|band |segment|does not move|signal|density|figures|lines of|a yield is required"
        r"|temperature|exponent|iteration did|from 0$|is a vector|what does not depend|makes no noise"
        r"|beside the other levels|level of noise"
        r"|two limits|lies between these|the input itself"
        r"|no noise reaches|the noise of .* begins in the last quarter",
        "Too few values, the wrong band, or a signal that stands still.",
        "Run longer, or choose another signal or band.",
    ),
    Explanation(
        "P0703",
        "The digital part has no such proof",
        r"digital part|exact linear form|no block in fixed point|needs two ends",
        "Overflow and rounding are proved of blocks in fixed point that add, scale, delay and limit.",
        "docs/how-to/prove.md says which claims there are. Ranges are those of wires into a FixedQuantiser.",
    ),
    Explanation(
        "P0801",
        "A function of an own block is refused",
        r"of the C library|no engine|is not declared|is not a function|compiled|has a type|what .* returns"
        r"|fixes a size|type that",
        "Functions of blocks are pure and use what docs/block-language.md lists, so that every engine gives the "
        "same bits.",
        "The message has file and line, and what to write instead. `proofmass test-block FILE` checks a file alone.",
    ),
    Explanation(
        "P0901",
        "Hardware cannot be written or tested",
        r"Verilog|C\+\+|pipeline|digital block|the model takes|another clock|not installed|GPU|bench|cut"
        r"|operation|format of",
        "A block has no circuit, or a tool for hardware is not there.",
        "docs/rtl.md lists which blocks become registers, and which tools are needed for what.",
    ),
    Explanation(
        "P1001",
        "A run cannot go on, or its traces do not fit",
        r"checkpoint|resume|timed on|do(es)? not fit|too large for memory|too long for CSV|changed since|interrupted"
        r"|ticks that are done",
        "A folder holds an interrupted run of another graph, seed or length, or a trace is larger than memory or disk.",
        "--restart begins anew; a probe may be thinned by every = 1000.",
    ),
    Explanation(
        "P1002",
        "A converter stood at the end of its range",
        r"end of its range",
        "What goes in is larger than the reference, so the codes say only that it is.",
        "Raise the reference, or lower the gain before it.",
    ),
    Explanation(
        "P1003",
        "A run ends where a block has no value",
        r"^(has no value|failed|is not finite) ",
        "A number grew beyond all bounds, or a block is given what it has no value for, such as a root of -1.",
        "Probe what drives the block, limit it by a Saturation, or look for a parameter or a unit that is far off.",
    ),
    Explanation(
        "P1101",
        "Workers cannot be reached",
        r"Dask|cluster|scheduler|worker",
        "A study with --dask needs a cluster that answers, with the same versions and files.",
        "docs/how-to/cluster.md shows how to start one; --dask local:4 starts workers here.",
    ),
)

_FIRST = (
    "P1002",
    "P1003",
    "P0503",
    "P0504",
    "P1101",
    "P0404",
    "P0401",
    "P0402",
    "P0405",
    "P0501",
    "P0502",
    "P1001",
)  # are special
_PATTERNS = [
    (re.compile(entry.messages), entry.code)
    for entry in sorted(EXPLANATIONS, key=lambda e: _FIRST.index(e.code) if e.code in _FIRST else len(_FIRST))
]


@lru_cache(maxsize=1024)
def code_of(message: str) -> str:
    """Return the code of the kind of fault that a message tells; empty where none fits.

    >>> code_of("unknown unit 'degC'")
    'P0301'
    """
    return next((code for pattern, code in _PATTERNS if pattern.search(message)), "")
