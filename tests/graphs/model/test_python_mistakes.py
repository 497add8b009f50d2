"""Mistakes that only Python allows: each error says what to write instead."""

import copy
import pickle
from typing import Any

import pytest

import proofmass
from proofmass import Block, Graph, Input, ModelError, block, check, param, simulate
from proofmass.blocks import Chirp, Gain, MassSpringDamper, SquareRoot, Step
from proofmass.blocks.declaration.other_functions import FUNCTIONS

GRAPH = Graph(
    name="a gain",
    rate="1 kHz",
    blocks={"step": Step(), "gain": Gain()},
    wires=["step.output -> gain.input"],
    probes=["gain.output"],
)
OWN = '''
from typing import NamedTuple
class Own(Block):
    """An own block."""
    gain: float = param("1", "Gain.", default=1.0)
    input = Input("V", "What is amplified.")
class State(NamedTuple):
    charge: float
{decorator}
def {name}(p, x: State, input: float) -> {result}:
    """What comes out."""
    return {value}
'''


def test_blocks_without_names_are_given_names() -> None:
    with pytest.raises(ModelError, match="the blocks have no names") as wrong:
        Graph(name="x", rate="1 kHz", blocks=[Step(), Gain(gain=2.0), Step()])  # type: ignore[arg-type]
    cure = wrong.value.problems[0].hint.partition("blocks=")[2]
    named = eval(cure, {"Step": Step, "Gain": Gain})
    assert named == {"step": Step(), "gain": Gain(gain=2.0), "step_2": Step()}


@pytest.mark.parametrize(
    "wires",
    [[("step.output", "gain.input")], [["step.output", "gain.input"]], {"step.output": "gain.input"}],
    ids=["tuple", "list", "table"],
)
def test_a_wire_is_one_text(wires: Any) -> None:
    with pytest.raises(ModelError) as wrong:
        Graph(name="x", rate="1 kHz", blocks=dict(GRAPH.blocks), wires=wires)
    assert wrong.value.problems[0].hint == 'write "step.output -> gain.input"'


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: MassSpringDamper(1e-9, 1, 2), r"write MassSpringDamper\(mass=1e-09, damping=1, stiffness=2\)"),
        (lambda: Graph("x", {}), r"Graph\(\): these arguments are named: name='x', blocks={}"),
        (lambda: Graph(), r'Graph\(\) needs name and blocks: add name="sensor", blocks={"step": Step\(\)}'),
        (lambda: Graph(blocks={}), r'Graph\(\) needs name: add name="sensor"$'),
        (lambda: simulate(), r'simulate\(\) needs graph: add graph="sensor.toml"'),
        (lambda: proofmass.sweep(GRAPH), r'sweep\(\) needs values: add values={"block.parameter": \[1.0, 2.0\]}'),
        (lambda: Graph(name="x", block={}), r"Graph\(\) has no argument block; did you mean blocks\?"),
        (lambda: Graph(name="x", blocks={}, dt=1), r"did you mean rate\?"),
        (lambda: simulate(GRAPH, "1 s"), r"these arguments are named: duration='1 s'"),
        (lambda: simulate(GRAPH, time="1 s"), r"did you mean duration\?"),
        (lambda: simulate(GRAPH, set={"gain.gain": 2}), r"graph\.with_parameters\("),
        (lambda: simulate(GRAPH), r'how long: simulate\(graph, duration="1 s"\)'),
        (lambda: simulate({}), r'not a graph\n  got:      \{\}\n  hint:     name its file, or write Graph\(name='),
        (lambda: proofmass.run_study("x.toml", jobs=2), r"did you mean threads\?"),
        (lambda: GRAPH.run(), r"simulate is a function: proofmass\.simulate\(graph\)"),
        (lambda: GRAPH.noise(), r"noise is a function: proofmass\.noise\(graph\)"),
        (lambda: GRAPH.plot(), r"a result draws itself, as simulate\(graph\)\.plot\(\)"),
        (lambda: GRAPH.load(), r"a graph has no attribute 'load'$"),
        (lambda: GRAPH.bode(), r"margins is a function: proofmass\.margins\(graph\)"),
        (lambda: GRAPH.set("gain.gain", 2), r'graph\.with_parameters\(\{"block\.parameter": \.\.\.\}\)'),
        (lambda: setattr(GRAPH, "rate", "2 kHz"), r'graph = graph\.with_parameters\(\{"rate": \.\.\.\}\)'),
        (lambda: setattr(GRAPH, "seed", 2), r"graph = graph\.changed\(seed=\.\.\.\)"),
        (lambda: setattr(Gain(), "gain", 2), r'graph\.with_parameters\(\{"block\.gain": \.\.\.\}\)'),
    ],
)  # fmt: skip
@pytest.mark.friendly(7, "mistakes in Python are answered by their cure")
def test_an_error_has_a_cure(call: Any, words: str) -> None:
    with pytest.raises((TypeError, AttributeError, ModelError), match=words):
        call()


def test_names_of_other_tools_lead_to_public_functions() -> None:
    assert {*FUNCTIONS} <= {*proofmass.__all__}
    assert not {word for others in FUNCTIONS.values() for word in others} & {*proofmass.__all__}


def test_the_cures_work() -> None:
    assert str(GRAPH.with_parameters({"rate": "2 kHz"}).rate) == "2000"
    assert GRAPH.changed(seed=2).seed == 2
    assert simulate(GRAPH, duration="1 s").ticks == 1001
    assert not [problem for problem in check(GRAPH) if not problem.note]


def test_a_graph_is_copied_and_sent() -> None:
    assert copy.deepcopy(GRAPH) == pickle.loads(pickle.dumps(GRAPH)) == GRAPH


@pytest.mark.parametrize(
    ("statement", "words"),
    [
        ("from proofmass.blocks import Integrater", "did you mean Integrator?"),
        ("from proofmass.blocks import Limiter", "here that is Saturation."),
        ("from proofmass import simulat", "did you mean simulate?"),
        ("from proofmass import Step", "from proofmass.blocks import Step"),
        ("from proofmass import load", "did you mean read_graph?"),
        ("from proofmass import run", "did you mean simulate?"),
        ("from proofmass import monte_carlo", "did you mean run_study?"),
        ("from proofmass import step", "did you mean response?"),
        ("from proofmass import plot", "a result draws itself"),
        ("from proofmass import lqr", "dir(proofmass) lists all names"),
    ],
)
def test_a_misspelt_import_names_the_nearest(statement: str, words: str) -> None:
    with pytest.raises(ImportError) as wrong:
        exec(statement, {})
    assert words in str(wrong.value)


def test_everything_is_imported_by_a_star() -> None:
    names: dict[str, Any] = {}
    exec("from proofmass.blocks import *\nfrom proofmass import *", names)
    assert names["Step"] is Step
    assert {"simulate", "Integrator", "Graph"} <= {*names}
    assert not {"Any", "import_module", "modules", "problem", "declaration"} & {*names}


def test_the_package_lists_nothing_but_what_it_offers() -> None:
    assert dir(proofmass) == sorted(["__version__", "blocks", *proofmass.__all__])
    assert not hasattr(proofmass, "simulat")
    assert all(name[:1].isupper() for name in dir(proofmass.blocks))


@pytest.mark.parametrize(
    ("decorator", "words"),
    [
        ("@Own.output", 'write @Own.output("V")'),
        ("@Own.output()", 'write @Own.output("V")'),
        ('@Own.output("V", "What comes out.")', 'write @Own.output("V")'),
        ("@Own.update()", "write @Own.update, without parentheses"),
        ("@Own.derivative", "write @Own.derivative(linear=False)"),
        ("@Own.derivative()", "write @Own.derivative(linear=False)"),
        ("@Own.derivative(False)", "write @Own.derivative(linear=False)"),
        ("@block", 'the parentheses are missing; write @block("V", voltage="V")'),
        ("@block()", 'the unit of the output is missing; write @block("V", voltage="V")'),
        ('@block(input="V")', 'the unit of the output is missing; write @block("V", voltage="V")'),
        ('@block("V", "V")', 'inputs are named; write @block("V", voltage="V")'),
        ('@block("V", unit="V", input="V")', "the unit of the output is given twice; write @block"),
        ("@block(3)", "unit is not a unit: 3; write @block"),
        ('@block("V", input=float)', "input is not a unit: <class 'float'>; write @block"),
        ('@block("V", input="V")(3)', "3 is not a function; write @block"),
    ],
)
@pytest.mark.friendly(7, "a wrong decorator is answered by its line")
def test_a_decorator_is_answered_by_its_line(decorator: str, words: str) -> None:
    output = "output" in decorator or "block" in decorator
    form = {"name": "level", "result": "float", "value": "input"} if output else {"name": "update", "value": "x"}
    text = OWN.format(decorator=decorator, **{"result": "State", **form})
    known = {"Block": Block, "Input": Input, "param": param, "block": block, "__name__": "own"}
    with pytest.raises(TypeError) as wrong:
        exec(text, known)
    assert words in str(wrong.value)
    if "block" not in decorator:
        cure = "@" + words.partition("@")[2].partition(",")[0]
        exec(text.replace(decorator, cure), {**known})


@pytest.mark.parametrize(
    ("name", "cure"),
    [
        ("duration", 'graph.with_parameters({"duration": ...})'),
        ("blocks", "graph.changed(blocks=...)"),
        ("gain", 'graph.with_parameters({"block.parameter": ...})'),
    ],
)
def test_an_assignment_is_told_its_cure(name: str, cure: str) -> None:
    with pytest.raises(AttributeError, match=f"cannot assign to {name}: a graph is a frozen value") as wrong:
        setattr(GRAPH, name, 1)
    assert str(wrong.value).endswith(f"; graph = {cure}")


@pytest.mark.parametrize(
    ("wire", "message", "hint"),
    [
        ("step.output -> chirp.start_frequency", "chirp.start_frequency cannot be driven", "the phase would not be"),
        ("part.a -> gain.input", "part.a is not an output", "a is a block inside: name its port too, part.a.PORT"),
    ],
)
def test_a_wire_to_what_cannot_be_driven_and_from_a_block_inside(wire: str, message: str, hint: str) -> None:
    part = Graph(name="", exports={"out": "a.output"}, blocks={"a": Step()})
    blocks = {"step": Step(), "gain": Gain(), "part": part, "chirp": Chirp()}
    graph = Graph(name="", rate="1 kHz", blocks=blocks, wires=[wire], probes=["gain.output"])
    (problem,) = (problem for problem in check(graph) if problem.message == message)
    assert problem.hint.startswith(hint)


def test_a_wire_without_ports_is_completed_where_units_are_too_long_to_compare() -> None:
    blocks = {"root": SquareRoot(unit="*".join(["kg/kg"] * 33)), "gain": Gain()}
    with pytest.raises(ModelError) as wrong:
        Graph(name="", rate="1 kHz", blocks=blocks, wires=["gain -> root"])
    assert wrong.value.problems[0].hint == 'write "gain.output -> root.input"'
