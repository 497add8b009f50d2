"""The schema of graph files takes what the reader takes, and refuses misspellings and numbers out of range."""

import json
import tomllib
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.catalog import all_blocks, facts
from proofmass.blocks.declaration.declare import block
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.top_keys import TOP_KEYS
from proofmass.graphs.schema.schema import graph_schema
from proofmass.runner.commands.schema_command import SCHEMA_FILE, STUDY_SCHEMA_FILE
from tests.by_hand.graph_schema import SCHEMA, STUDY_SCHEMA, STUDY_VALIDATOR, of_kind, validator_of
from tests.by_hand.graph_texts import LIBRARY, SMALL, STUDIES, changed
from tests.by_hand.study_texts import RICH, STUDY

KINDS = all_blocks()


def valid(text: str) -> bool:
    table = tomllib.loads(text)
    return bool(validator_of(table).is_valid(table))


def with_some_kinds(schema: dict[str, Any], apart: int) -> dict[str, Any]:
    """What a schema says of each `apart`-th kind of block, and all that it says of anything else."""
    block = schema["$defs"]["block"]
    rules = block["then"] | {"allOf": block["then"]["allOf"][::apart]}
    return schema | {"$defs": schema["$defs"] | {"block": block | {"then": rules}}}


@pytest.mark.parametrize(
    "schema",
    [with_some_kinds(SCHEMA, 10), pytest.param(SCHEMA, marks=pytest.mark.exhaustive), STUDY_SCHEMA],
    ids=["graph of some kinds", "graph", "study"],
)
def test_it_is_a_schema(schema: dict[str, Any]) -> None:
    jsonschema.Draft202012Validator.check_schema(schema)


def defaults(schema: Any) -> Iterator[dict[str, Any]]:
    """Yield every plain form of a schema that has a default."""
    if isinstance(schema, dict):
        if "default" in schema and "type" in schema:
            yield schema
        yield from chain.from_iterable(map(defaults, schema.values()))
    elif isinstance(schema, list):
        yield from chain.from_iterable(map(defaults, schema))


@pytest.mark.parametrize("schema", [SCHEMA, STUDY_SCHEMA], ids=["graph", "study"])
def test_defaults_have_their_form(schema: dict[str, Any]) -> None:
    forms = [*defaults(schema)]
    assert forms
    assert [form for form in forms if not jsonschema.Draft202012Validator(form).is_valid(form["default"])] == []


def test_the_schemas_are_small() -> None:
    lengths = [len(json.dumps(schema, separators=(",", ":"))) for schema in (SCHEMA, STUDY_SCHEMA)]
    assert sum(lengths) < 200_000
    assert "properties" in SCHEMA
    assert "properties" in STUDY_SCHEMA


@pytest.mark.exhaustive(but=12)
@pytest.mark.parametrize("path", [*LIBRARY, *STUDIES], ids=lambda path: path.stem)
@pytest.mark.friendly(12, "every graph of the library is valid")
def test_the_library_is_valid_and_names_its_schema(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert text.startswith(f"#:schema {STUDY_SCHEMA_FILE if path in STUDIES else SCHEMA_FILE}\n")
    table = tomllib.loads(text)
    assert [error.message for error in validator_of(table).iter_errors(table)] == []


@pytest.mark.exhaustive(but=80)
@pytest.mark.parametrize("kind", KINDS.values(), ids=lambda kind: kind.__name__)
def test_every_block_as_it_is_written_is_valid(kind: Any) -> None:
    assert valid(write_graph(Graph(name="", blocks={"block": kind()})))


@pytest.mark.parametrize("kind", KINDS.values(), ids=lambda kind: kind.__name__)
def test_every_parameter_has_its_doc_default_and_bounds(kind: Any) -> None:
    properties = of_kind(SCHEMA, kind.__name__)
    assert set(properties) - {"kind", "rate", "clock_offset"} == set(kind.parameters)
    assert ("rate" in properties) != kind.continuous()
    for name, parameter in facts(kind)["parameters"].items():
        described = properties[name]
        assert described["description"].startswith(parameter["doc"].rstrip("."))
        assert described["default"] == parameter["default"]
        assert (
            parameter["unit"].replace("{", "").replace("}", "") in described["description"] or parameter["unit"] == "1"
        )


@pytest.mark.parametrize("kind", KINDS.values(), ids=lambda kind: kind.__name__)
def test_defaults_are_valid_and_what_is_out_of_bounds_is_not(kind: Any) -> None:
    for name, parameter in kind.parameters.items():
        own = jsonschema.Draft202012Validator(of_kind(SCHEMA, kind.__name__)[name] | {"$defs": SCHEMA["$defs"]})
        default = list(parameter.default) if isinstance(parameter.default, tuple) else parameter.default
        default = str(default) if isinstance(default, Fixed) else default
        assert own.is_valid(default), name
        if parameter.kind not in (float, int):
            continue
        outside = [parameter.above, parameter.below]
        outside += [bound - _step(parameter, bound) for bound in [parameter.at_least] if bound is not None]
        outside += [bound + _step(parameter, bound) for bound in [parameter.at_most] if bound is not None]
        for bound in outside:
            assert bound is None or not own.is_valid(bound), name
        assert not own.is_valid([1]), name
        assert not own.is_valid(True), name


def _step(parameter: Any, bound: float) -> float:
    return 1 if parameter.kind is int else 1e-9 * max(1.0, abs(bound))


def test_every_key_of_the_top_is_described() -> None:
    assert list(SCHEMA["properties"]) == list(TOP_KEYS)
    assert all(entry["description"] for entry in SCHEMA["properties"].values())


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('name = "a mass', 'nmae = "a mass'),
        ('"Gain"', '"Gian"'),
        ('kind = "Gain"', ""),
        ('kind = "Gain"', 'knid = "Gain"'),
        ("bits = 16", "bist = 16"),
        ("bits = 16", "bits = 33"),
        ("bits = 16", "bits = 1"),
        ("bits = 16", "bits = 16.5"),
        ("bits = 16", "reference = 0.0"),
        ("bits = 16", 'reference = "five volts"'),
        ("bits = 16", "reference = true"),
        ("bits = 16", "rate = -1"),
        ('kind = "MassSpringDamper"', 'kind = "MassSpringDamper"\nrate = "1 kHz"'),
        ("[blocks.adc]", "[blocks.Adc]"),
        ("[blocks.adc]", f"[blocks.{'a' * 65}]"),
        ('"push.output -> mass.force"', '"push.output > mass.force"'),
        ('"push.output -> mass.force"', "5"),
        ('probes = ["adc.code"]', 'probes = ["adc"]'),
        ('probes = ["adc.code"]', 'probes = [{ signal = "adc.code", every = 0 }]'),
        ('probes = ["adc.code"]', 'probes = [{ signal = "adc.code", evry = 2 }]'),
        ('duration = "1 s"', "samples = 0"),
        ('duration = "1 s"', 'duration = "1 s"\nsamples = 5'),
        ('duration = "1 s"', "duration = -1"),
        ('duration = "1 s"', "seed = -1"),
    ],
)
def test_mistakes_are_not_valid(old: str, new: str) -> None:
    assert valid(SMALL)
    assert not valid(changed(SMALL, old, new))


@pytest.mark.parametrize(
    ("measure", "right"),
    [
        ('statistic = "mean"', True),
        ('statistic = "mean", from = "1 ms"', True),
        ('statistic = "mean", tau = 1', False),
        ('statistic = "maen"', False),
        ('statistic = "percentile", percent = 99', True),
        ('statistic = "percentile", percent = 100', False),
        ('statistic = "percentile"', False),
        ('statistic = "percentile", percent = 9, within = 1', False),
        ('statistic = "allan_deviation", tau = "1 s"', True),
        ('statistic = "settling_time", target = 1, within = "1 mV"', True),
        ('statistic = "settling_time", target = 1', False),
    ],
)
def test_measures(measure: str, right: bool) -> None:
    assert valid(f'{SMALL}\n[measures]\nbias = {{ signal = "adc.code", {measure} }}\n') == right


@pytest.mark.parametrize("text", [STUDY, RICH], ids=["plain", "rich"])
def test_studies_are_valid(text: str) -> None:
    assert valid(text)
    table = tomllib.loads(text)["study"]
    assert STUDY_VALIDATOR.is_valid(table | {"graph": "sensor.toml"})
    assert not STUDY_VALIDATOR.is_valid(table | {"grahp": "sensor.toml"})
    assert not STUDY_VALIDATOR.is_valid(table)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("runs = 8", "rnus = 8"),
        ("runs = 8", "runs = 0"),
        ("runs = 8", 'graph = "sensor.toml"'),
        ("seed = 5", "seed = -1"),
        ('"latin_hypercube"', '"latin"'),
        ("{ normal = ", "{ nromal = "),
        ("{ normal = ", "{ uniform = 1, normal = "),
        ('normal = "200 ppm"', "normal = -1"),
        ('relative = true }\n"source', 'relative = 1 }\n"source'),
        (', column = "offset"', ""),
        ("lognormal = 0.1", "lognormal = 0.1, weights = [1]"),
        ("lognormal = 0.1", "lognormal = 0.1, truncated = 0"),
        ("lognormal = 0.1", "uniform = 0.1, truncated = 3"),
        ("weights = [3, 1]", "weights = []"),
        ("weights = [3, 1]", "weights = [3, -1]"),
        ("= -0.5", "= -1.5"),
        ('ages = ["0 h", "1 year"]', "ages = []"),
        ("ages =", "age ="),
        ("arrhenius =", "arhenius ="),
        ('arrhenius = "4 ppm/year"', 'ramp = "4 ppm/year"'),
        ("at_least = 0", "at_lest = 0"),
        ("at_least = 0", 'at_least = "five"'),
        ("bias = 0.5", "bias = -0.5"),
        ("bias = 0.5", "Bias = 0.5"),
    ],
)
def test_mistakes_in_studies_are_not_valid(old: str, new: str) -> None:
    assert not valid(changed(RICH, old, new))


@pytest.mark.parametrize(
    "text",
    [
        "5 V",
        "5V",
        " 5.0 mV ",
        "-1e-3",
        "+.5 µV",
        "1_000 V",
        "1/3 V",
        "5 kg*m^2/(s^3 A)",
        "3 1/s",
        "0.1 %",
        "9.8 m/s²",
        "10 µg0/√Hz",
        "2 °/h",
        "3 N·m",
    ],
)
def test_quantities_are_valid(text: str) -> None:
    assert jsonschema.Draft202012Validator(SCHEMA["$defs"]["quantity"]).is_valid(text)


@pytest.mark.parametrize("text", ["", "V", "five", "e5 V", "5 V; x", "5 $", "--5", "1/ V\n"])
def test_what_is_no_quantity_is_not(text: str) -> None:
    assert not jsonschema.Draft202012Validator(SCHEMA["$defs"]["quantity"]).is_valid(text)


PARTS = 'exports = { code = "part.code" }\n[blocks.part]\ngraph = "part.toml"\ncount = 3\nrate = "1 kHz"\n'


@pytest.mark.parametrize(
    "text",
    [
        PARTS,
        PARTS + '"adc.bits" = 3\nreference = "5 V"\nchannel.adc.bits = 3\n',
        SMALL.replace("blocks.", "blocks.a.blocks."),
    ],
)
def test_subgraphs_are_valid(text: str) -> None:
    assert valid(text)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("count = 3", "count = 0"),
        ("count = 3", "Adc = 3"),
        ("count = 3", 'kind = "Gain"'),
        ('"part.toml"', "5"),
        ('"part.code"', '"part"'),
        ("{ code", "{ Code"),
        ("{ code", "{ rate"),
        ("exports =", "export ="),
    ],
)
def test_mistakes_in_subgraphs_are_not_valid(old: str, new: str) -> None:
    assert not valid(changed(PARTS, old, new))


def test_choices_and_own_blocks() -> None:
    from proofmass.blocks.declaration.declare import Block, param

    class Chooser(Block):
        """A block with a choice."""

        mode: str = param("", "Which.", default="fast", choices=("fast", "slow"))

    @block("V", voltage="V")
    def doubled(p: Any, voltage: float) -> float:
        """Twice the voltage."""
        return 2.0 * voltage

    own = graph_schema({"Chooser": Chooser, "Doubled": doubled})
    validator = jsonschema.Draft202012Validator(own)
    assert validator.is_valid({"blocks": {"a": {"kind": "Chooser", "mode": "slow"}, "b": {"kind": "Doubled"}}})
    assert not validator.is_valid({"blocks": {"a": {"kind": "Chooser", "mode": "slwo"}}})
    assert of_kind(own, "Chooser")["mode"]["description"] == "Which"
