"""Tables of a graph that say something impossible: each is refused at its line, with what was meant or expected."""

import pytest

from proofmass.graphs.model.integration import MOST_SUBSTEPS
from proofmass.graphs.model.values import MOST_VALUES
from tests.by_hand.graph_texts import SMALL, line_of, problems_of

MEASURED = SMALL + '\n[measures]\nmean = { signal = "adc.code", statistic = "mean" }\n'
HUGE = "1" + "0" * 350  # an integer that no float holds


def only_problem(text: str, at: str) -> str:
    """The one problem of a text, which must be at the line of a piece of it."""
    (problem,) = problems_of(text)
    place, _, said = str(problem).partition(": ")
    assert place == f"model.toml:{line_of(text, at)}"
    return said


@pytest.mark.parametrize("key", ["exports", "formulas", "measures", "integration", "values", "requirements"])
def test_a_number_in_place_of_a_table(key: str) -> None:
    text = SMALL.replace("probes", f"{key} = 5\nprobes")
    assert only_problem(text, f"{key} = 5").startswith(f"{key}: must be a table\n  got:      5\n  hint:     write ")


@pytest.mark.parametrize(
    ("table", "at", "said", "words"),
    [
        ('[formulas]\n"adc.bits" = 5\n', '"adc.bits"', "formulas.adc.bits: must be a text that begins with =", ""),
        ("[measures]\nx = 5\n", "x = 5", "measures.x: must be a table", 'statistic = "mean"'),
        ('[measures]\nx = { formula = "5" }\n', "x =", "measures.x.formula: must be a text that begins with =", ""),
        ('[measures]\nx = { formula = "= 1", unti = "V" }\n', "x =", "measures.x.unti: unknown key", "mean unit?"),
        ("[integration]\naccuracy = 1.0\n", "accuracy", "integration.accuracy: must be a number", "1e-14 to 0.1"),
        ("[integration]\naccuracy = true\n", "accuracy", "integration.accuracy: must be a number", "1e-14 to 0.1"),
        ("[integration]\nsubsteps = 0\n", "substeps", "integration.substeps: must be an", f"1 to {MOST_SUBSTEPS}"),
        ('[integration]\nmethod = "exakt"\n', "method", "integration.method: there is no such choice", "mean exact?"),
        ('[integration]\nmetod = "exact"\n', "metod", "integration.metod: unknown key", "did you mean method?"),
        ('[integration]\nevent_tolerance = "0 s"\n', "event", "integration.event_tolerance: must be above", "'0 s'"),
        ('[integration]\nevent_tolerance = "1 V"\n', "event", "integration.event_tolerance: V is", "give it in s"),
        ("[values]\nMass = 5\n", "Mass =", "values.Mass: not a name", "lower-case letters"),
        ("[values]\nsqrt = 5\n", "sqrt", "values.sqrt: the name is taken: sqrt is a function", "choose another"),
        ("[values]\npi = 5\n", "pi = 5", "values.pi: the name is taken: pi is a constant", "choose another"),
        ("[values]\nx = inf\n", "x = inf", "values.x: must be finite", "got:      inf"),
        ('[values]\nx = "1e350 m"\n', "x =", "values.x: is too large for a number", "1e350 m"),
        ('[values]\nx = "= 1e350 m"\n', "x =", "values.x: holds a number that is too large", "= 1e350 m"),
        ('[values]\nx = "= 1 m + 1 s"\n', "x =", "values.x: a sum takes m and s", "= 1 m + 1 s"),
    ],
)  # fmt: skip
def test_an_entry_of_a_table(table: str, at: str, said: str, words: str) -> None:
    text = f"{SMALL}\n{table}"
    told = only_problem(text, at)
    assert told.startswith(said)
    assert words in told


def test_more_values_than_a_graph_has() -> None:
    text = SMALL + "\n[values]\n" + "".join(f"x{number} = 1\n" for number in range(MOST_VALUES + 1))
    assert only_problem(text, "[values]") == "values: too many\n  got:      1001\n  expected: at most 1000"


@pytest.mark.parametrize(
    ("entry", "said", "words"),
    [
        ('x = { signal = "adc.code", statistic = "mean", unit = 5 }', "measures.x.unit: must be a text", "deg/h"),
        ('x = { signal = "adc.code", statistic = "mean", unit = "foo" }', "measures.x.unit: unknown unit 'foo'", ""),
        ('x = { signal = "adc.code", statistic = "mean", unit = "V" }', "measures.x.unit: cannot be shown in V", "or"),
        ('x = { signal = "adc.cod", statistic = "mean" }', "measures.x.signal: adc.cod is not an output", "mean code?"),
        ('x = "= 2 * bits"', "measures.x: bits is a value: a measure follows from measures alone", "write bits as a"),
    ],
)  # fmt: skip
def test_a_measure(entry: str, said: str, words: str) -> None:
    text = f"{MEASURED}{entry}\n\n[values]\nbits = 16\n"
    told = only_problem(text, "x =")
    assert told.startswith(said)
    assert words in told


def test_what_follows_from_a_wrong_measure_has_no_problem_of_its_own() -> None:
    text = MEASURED.replace("adc.code", "adc.cod").replace('probes = ["adc.cod"]', "probes = []")
    text += 'double = "= 2 * mean"\n[requirements.one]\nquantity = "double"\nat_least = 1\n'
    assert only_problem(text, "mean = {").startswith("measures.mean.signal: adc.cod is not an output")


def test_a_fixed_point_value_is_not_measured() -> None:
    text = SMALL.replace('adc.voltage",', 'adc.voltage",\n    "readout.output -> quantiser.input",')
    table = '\n[blocks.quantiser]\nkind = "FixedQuantiser"\nunit = "V"\n'
    text += table + '[measures]\nx = { signal = "quantiser.output", statistic = "mean" }\n'
    told = only_problem(text, "x =")
    assert told.startswith("measures.x.signal: a fixed-point value cannot be measured")
    assert "measure the number that it is converted to" in told


@pytest.mark.parametrize(
    ("limits", "at", "said", "words"),
    [
        ("at_least = nan", "at_least", "at_least: must be a number", "got:      nan"),
        ('at_least = "1e350"', "at_least", "at_least: too large for a number", "a quantity in 1"),
        (f"at_least = {HUGE}", "at_least", "at_least: is too large for a number", "an integer of over 30 digits"),
        ("at_least = 1\ntext = 5", "text =", "text: must be a text", "got:      5"),
        (f'at_least = 1\ntext = "{"a" * 4001}"', "text =", "text: must be a text", "'aaaa"),
        ('at_least = 1\ntolerances = { "adc.code" = 0.1 }', "tolerances", "tolerances: adc.code is not", "of adc"),
        ('at_least = 1\ntolerances = { "adc.bitz" = 0.1 }', "tolerances", "tolerances: adc.bitz is neither", "bits"),
    ],
)  # fmt: skip
def test_a_requirement(limits: str, at: str, said: str, words: str) -> None:
    told = only_problem(f'{MEASURED}\n[requirements.one]\nquantity = "mean"\n{limits}\n', at)
    assert told.startswith(f"requirements.one.{said}")
    assert words in told


def test_a_tolerance_of_a_value_is_one() -> None:
    tables = '[values]\nbits = 16\n[requirements.one]\nquantity = "mean"\nat_least = 1\ntolerances = { bits = "5 %" }\n'
    assert problems_of(f"{MEASURED}\n{tables}") == []


RESPONSE = 'response = "readout.output", input = "push.output"'
NOT_IN_HERTZ = "must be a frequency", 'the gain needs one: add frequency = "100 Hz"'
ONE_BAND = "must be two frequencies", 'write band = ["1 Hz", "100 Hz"]'
TOO_LARGE = pytest.mark.defect(
    "S705", before="a frequency of 350 digits ended in a traceback", after="it is refused at its line"
)


@pytest.mark.parametrize(
    ("quantity", "key", "said", "words"),
    [
        ('loop = "main", measure = "mean"', "", "must name one quantity", "one of loop, noise"),
        ('measure = "mean", band = ["1 Hz", "2 Hz"]', ".band", "measure has no band", "leave it out"),
        ('loop = "adc.cod", figure = "phase_margin"', ".loop", "adc.cod is not an output", "did you mean code?"),
        ('loop = "main", figure = "phase_margin"', ".loop", "there is no such loop", 'output: "mass.displacement"'),
        (f'{RESPONSE}, figure = "gian"', ".figure", "there is no such figure", "did you mean gain?"),
        (f'{RESPONSE}, figure = "bandwidth", frequency = 1', ".frequency", "bandwidth has no", "leave it out"),
        (f"{RESPONSE}, frequency = -1", ".frequency", *NOT_IN_HERTZ),
        (f"{RESPONSE}, frequency = true", ".frequency", *NOT_IN_HERTZ),
        (f"{RESPONSE}, frequency = [1]", ".frequency", *NOT_IN_HERTZ),
        (f'{RESPONSE}, frequency = "1 V"', ".frequency", "V is m^2*kg/s^3/A, not 1/s", "give it in Hz"),
        pytest.param(f"{RESPONSE}, frequency = {HUGE}", ".frequency", *NOT_IN_HERTZ, marks=TOO_LARGE),
        ("noise = 5", ".noise", "not an output", 'write "block.output"'),
        ('noise = "readout.output", band = ["1 Hz"]', ".band", *ONE_BAND),
        ('noise = "readout.output", band = [1, [2]]', ".band", *ONE_BAND),
        ('noise = "readout.output", band = ["1 V", "2 V"]', ".band", "V is m^2*kg/s^3/A, not 1/s", "two frequencies"),
        pytest.param(f'noise = "readout.output", band = [1, {HUGE}]', ".band", *ONE_BAND, marks=TOO_LARGE),
    ],
)  # fmt: skip
def test_a_quantity(quantity: str, key: str, said: str, words: str) -> None:
    text = f"{MEASURED}\n[requirements.one]\nat_least = 1\nquantity = {{ {quantity} }}\n"
    told = only_problem(text, "quantity = {")
    assert told.startswith(f"requirements.one.quantity{key}: {said}")
    assert words in told


@pytest.mark.parametrize("frequency", ["0", "0.5", '"0.1 Hz"'])
def test_a_frequency_may_be_low(frequency: str) -> None:
    quantity = f"{{ {RESPONSE}, frequency = {frequency} }}"
    assert problems_of(f"{MEASURED}\n[requirements.one]\nat_least = 1\nquantity = {quantity}\n") == []


@pytest.mark.defect(
    "S706",
    before='a wrong formula below [formulas] was reported at the line of the block, where "adc.bitz" does not stand',
    after="it is reported at its own line",
)
@pytest.mark.parametrize(
    ("target", "formula", "said", "words"),
    [
        ("adc.bitz", "= 2", "AnalogToDigital has no parameter bitz", "did you mean bits?"),
        ("adc.bits", "= 2.5", "must be an integer, not 2.5", "= 2.5"),
        ("push.unit", "= 2", "is a text: a formula gives one number", "write it out"),
        ("adc.rate", "= 0 s", "must be above zero, not 0 s", "= 0 s"),
        ("adc.clock_offset", "= -1 us", "must be at least zero, not -1e-06 s", "= -1 us"),
        ("filter.taps[5]", "= 2", "taps has no entry 5", "it has 2, the first being 0"),
        ("filter.taps", "= 2", "is a list: a formula gives one number", 'its entries formulas, ["= a", "= b"]'),
        ("duration", "= 1 V", "is V, not s", "the result must be in s"),
    ],
)
def test_a_formula_of_the_table(target: str, formula: str, said: str, words: str) -> None:
    text = SMALL.replace('adc.voltage",', 'adc.voltage",\n    "adc.number -> filter.input",')
    text += '\n[blocks.filter]\nkind = "FiniteImpulseResponse"\ntaps = [1, 2]\n'
    text += f'\n[formulas]\n"{target}" = "{formula}"\n'
    told = only_problem(text, f'"{target}" =')
    assert told.startswith(f"{target}: {said}")
    assert words in told


def test_a_formula_at_a_parameter_is_reported_there() -> None:
    text = SMALL.replace("bits = 16", 'bits = "= 2.5"')
    assert only_problem(text, "bits =").startswith("blocks.adc.bits: must be an integer, not 2.5")


def test_a_wire_into_a_part_of_a_block() -> None:
    text = SMALL.replace('"readout.output ->', '"readout.inner.output ->')
    told = only_problem(text, '"readout.inner')
    assert told.endswith("readout is a block without blocks inside\n  hint:     name a port of it: readout.PORT")


def test_names_that_are_none_are_told_what_wires_call_them() -> None:
    text = SMALL.replace("[blocks.adc]", "[blocks.adc__]").replace("[blocks.mass]", "[blocks.mass__]")
    text = text.replace("wires = [", 'wires = [\n    5,\n    "a..b -> adc.voltage",\n    "B__.x -> adc.voltage",')
    names = [problem for problem in problems_of(text) if problem.message == "not a name"]
    assert [(problem.got, problem.hint) for problem in names] == [
        ("'mass__'", "did you mean mass?"), ("'adc__'", "did you mean adc?")
    ]  # fmt: skip


def test_names_of_measures_are_not_told_what_wires_call_blocks() -> None:
    text = SMALL.replace("[blocks.adc]", "[blocks.adc__]") + '[measures.Adc]\nsignal = "adc__.code"\n'
    (hint,) = (problem.hint for problem in problems_of(text) if problem.got == "'Adc'")
    assert hint == ""
