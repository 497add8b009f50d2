"""The declaration of blocks: what a class and its functions say, and what cannot be said."""

import dataclasses
from collections.abc import Callable
from typing import Any, NamedTuple

import pytest

from proofmass.blocks import PID, Correlator, Gain, MassSpringDamper, ShiftRegister
from proofmass.blocks.declaration.catalog import all_blocks, facts
from proofmass.blocks.declaration.declare import Block, Buffer, Input, Recording, block, param
from proofmass.blocks.declaration.instance import shape_of, size_of, unit_of
from proofmass.blocks.declaration.problem import ModelError
from proofmass.blocks.declaration.unit_expressions import unit
from tests.by_hand.fresh_blocks import fresh_block
from tests.by_hand.functions import drive


class Mixer(Block):
    """Two inputs, two outputs, state and a buffer."""

    depth: int = param("1", "Entries of the buffer.", default=3, at_least=1)
    scale: float = param("{unit}", "A factor.", default=2.0)
    start_value: float = param("{unit}", "A start.", default=0.0)
    weights: tuple[float, ...] = param("1", "A list.", default=(1.0, 2.0))
    active: bool = param("", "A switch.", default=True)
    unit: str = param("", "Unit.", default="V")

    left = Input("{unit}", "Left.")
    right = Input("{unit}", "Right.", default=0.0)

    line = Buffer("Entries.", float, ("depth",))
    twice = Buffer("Twice as many.", int, (lambda p: 2 * p.depth,))
    weighted = Buffer("One per weight.", float, ("weights",))
    fixed = Buffer("Four.", float, (4,))


class State(NamedTuple):
    held: float


@Mixer.start
def start(p: Mixer) -> State:
    return State(p.start_value)


@Mixer.output("{unit}")
def through(p: Mixer, x: State, left: float) -> float:
    """Left, at once."""
    return left + x.held


@Mixer.output("{unit}")
def later(p: Mixer, x: State) -> float:
    """Right, a tick later."""
    return x.held


@Mixer.output("1", shape=("depth",), dtype=int, every="depth")
def entries(p: Mixer, right: float, out: Any) -> None:
    """A vector."""


@Mixer.update
def update(p: Mixer, x: State, right: float) -> State:
    return State(right)


# -- what is declared -------------------------------------------------------------------------------------------------


def test_feedthrough_is_per_port() -> None:
    assert Mixer.feedthrough("through") == ("left",)
    assert Mixer.feedthrough("later") == ()
    assert Mixer.feedthrough("entries") == ("right",)


def test_sizes_from_numbers_parameters_lists_and_functions() -> None:
    mixer = Mixer(depth=5, weights=[1.0, 2.0, 3.0])
    assert {name: shape_of(mixer, buffer) for name, buffer in type(mixer).buffers.items()} == {
        "line": (5,),
        "twice": (10,),
        "weighted": (3,),
        "fixed": (4,),
    }
    assert shape_of(mixer, type(mixer).outputs["entries"]) == (5,)
    assert size_of(mixer, type(mixer).outputs["entries"].every) == 5
    assert size_of(mixer, type(mixer).outputs["later"].every) == 1


def test_units_dtypes_and_docs_of_ports() -> None:
    mixer = Mixer(unit="mN")
    assert unit_of(mixer, type(mixer).outputs["through"]) == "mN"
    assert unit_of(mixer, type(mixer).parameters["scale"]) == "mN"
    assert {name: port.dtype for name, port in Mixer.outputs.items()} == {
        "through": float,
        "later": float,
        "entries": int,
    }
    assert Mixer.outputs["later"].doc == "Right, a tick later."
    assert Mixer.inputs["left"].default is None
    assert Mixer.inputs["right"].default == 0.0


def test_only_plain_numbers_that_no_start_rests_on_can_be_driven() -> None:
    assert {name: Mixer.drivable(name) for name in Mixer.parameters} == {
        "depth": False,
        "scale": True,
        "start_value": False,
        "weights": False,
        "active": False,
        "unit": False,
    }
    assert PID.drivable("proportional")
    assert not PID.drivable("limited")
    assert all(MassSpringDamper.drivable(name) for name in MassSpringDamper.parameters)


def test_state_constants_and_parameters_classes() -> None:
    assert Mixer.state_class() is State
    assert Gain.state_class() is None
    assert Mixer.constants_class() is Mixer.parameters_class()
    assert Mixer.parameters_class().__annotations__ == {
        "depth": int,
        "scale": float,
        "start_value": float,
        "active": bool,
        "weights": tuple[float, ...],
    }
    assert ShiftRegister.constants_class().__name__ == "Constants"
    assert Mixer.parameters_class() is not Gain.parameters_class()


def test_continuous_is_having_a_derivative() -> None:
    assert MassSpringDamper.continuous()
    assert MassSpringDamper.linear
    assert not Mixer.continuous()
    assert not Mixer.linear


def test_a_block_is_a_frozen_value() -> None:
    gain = Gain(gain=2.0)
    with pytest.raises(dataclasses.FrozenInstanceError):
        gain.gain = 3.0  # type: ignore[misc]
    assert gain == Gain(gain="2")
    assert hash(gain) == hash(Gain(gain=2))
    assert gain != Gain()
    assert repr(gain) == "Gain(gain=2.0)"
    assert repr(Gain()) == "Gain()"


def test_declarations_do_not_leak_into_other_blocks() -> None:
    assert (Block.inputs, Block.outputs, Block.buffers, Block.functions, Block.parameters) == ({}, {}, {}, {}, {})
    assert list(Gain.inputs) == ["input"]
    assert Gain.buffers == {}
    assert "sums" in Correlator.buffers


def test_a_recording_is_a_buffer_filled_from_outside() -> None:
    class Played(Block):
        """A recording."""

        moments = Recording("time", "When.")

    assert Played.buffers["moments"].recorded == "time"
    assert Played.buffers["moments"].shape == ()


def test_a_block_of_one_function() -> None:
    @block("V", voltage="V", reference="V")
    def above_reference(p: Any, voltage: float, reference: float) -> float:
        """What is above the reference."""
        return voltage - reference if voltage > reference else 0.0

    kind: Any = above_reference
    assert issubclass(kind, Block)
    assert kind.__name__ == "AboveReference"
    assert kind.__doc__ == "What is above the reference."
    assert kind.feedthrough("above_reference") == ("voltage", "reference")
    assert kind.outputs["above_reference"].unit == "V"
    rows = drive(kind(), [{"voltage": 3.0, "reference": 1.0}, {"voltage": 0.5, "reference": 1.0}])
    assert [row["above_reference"] for row in rows] == [2.0, 0.0]
    with pytest.raises(TypeError, match=r"Half.half: cannot bind the argument \['volts'\]; did you mean voltage"):

        @block("V", voltage="V")
        def half(p: Any, volts: float) -> float:
            return 0.5 * volts


# -- what is refused of a user ----------------------------------------------------------------------------------------


def test_an_unknown_parameter_and_the_nearest_one() -> None:
    with pytest.raises(ModelError) as error:
        MassSpringDamper(dampign=1.0, mass=-1.0)
    assert str(error.value) == (
        "MassSpringDamper.dampign: MassSpringDamper has no such parameter\n"
        "  got:      dampign\n"
        "  hint:     did you mean damping?\n"
        "MassSpringDamper.mass: must be > 0\n"
        "  got:      -1.0 kg\n"
        "  expected: a number > 0, in kg"
    )
    assert [problem.path for problem in error.value.problems] == [("dampign",), ("mass",)]


def test_requirements_are_asked_only_of_valid_parameters() -> None:
    with pytest.raises(ModelError) as error:
        PID(lowest=5.0, proportional=float("nan"))
    assert [problem.key for problem in error.value.problems] == ["PID.proportional"]
    with pytest.raises(ModelError) as error:
        PID(lowest=5.0)
    assert str(error.value) == (
        "PID.lowest: does not go with the other parameters\n  got:      5.0\n  expected: less than highest = 1"
    )


def test_a_port_name_is_no_parameter() -> None:
    with pytest.raises(ModelError, match="the parameters of Gain: gain, input_unit, output_unit"):
        Gain(linear=True)


def test_units_of_ports_are_checked_with_the_parameters() -> None:
    with pytest.raises(ModelError) as error:
        Gain(input_unit="volt", gain=1.0)
    assert str(error.value).startswith("Gain.input_unit: unknown unit 'volt'\n  got:      'volt'\n  expected: a unit\n")
    with pytest.raises(ModelError, match="a unit of over 200 characters"):
        Gain(input_unit="m*" * 1000 + "m")


# -- what is refused of an author of blocks ---------------------------------------------------------------------------


def test_arguments_are_bound_by_name() -> None:
    def output(p: Any, voltag: float) -> float:
        return voltag

    def update(p: Any, volts: float) -> State:
        return State(volts)

    def constants(p: Any, periods: float) -> State:
        return State(periods)

    def starting(p: Any, voltage: float) -> State:
        return State(voltage)

    def nothing() -> float:
        return 0.0

    kind = fresh_block()
    with pytest.raises(TypeError, match=r"Fresh.output: cannot bind the argument \['voltag'\]; did you mean voltage\?"):
        kind.output("V")(output)
    with pytest.raises(TypeError, match=r"Fresh.update: cannot bind the argument \['volts'\]"):
        kind.update(update)
    with pytest.raises(TypeError, match=r"cannot bind the argument \['periods'\]; did you mean period\?"):
        kind.constants(constants)
    with pytest.raises(TypeError, match=r"cannot bind the argument \['voltage'\]; the arguments: cells"):
        kind.start(starting)
    with pytest.raises(TypeError, match="the first argument is the constants"):
        kind.output("V")(nothing)


def test_an_output_returns_one_number_or_writes_a_vector() -> None:
    def text(p: Any) -> str:
        return ""

    def unsaid(p: Any):  # type: ignore[no-untyped-def]
        return 0.0

    def vector(p: Any, out: Any) -> None:
        return None

    def number(p: Any) -> float:
        return 0.0

    kind = fresh_block()
    wrong: list[tuple[Callable[..., Any], dict[str, Any]]] = [
        (text, {}),
        (unsaid, {}),
        (vector, {}),
        (vector, {"dtype": float}),
        (vector, {"shape": (3,)}),
        (number, {"shape": (3,)}),
    ]
    for function, options in wrong:
        with pytest.raises(
            TypeError, match="must return float, int, bool or FixedValue, or write its entries into out"
        ):
            kind.output("V", **options)(function)
    assert kind.outputs == {}
    kind.output("V", shape=(3,), dtype=float)(vector)
    assert kind.outputs["vector"].shape == (3,)


@pytest.mark.parametrize("annotation", [complex, list, "int | None"])
def test_parameters_have_one_of_six_types(annotation: Any) -> None:
    with pytest.raises(TypeError, match=r"must be float, int, bool, str, Fixed or tuple\[float, ...\] = param"):
        type(
            "Wrong",
            (Block,),
            {"factor": param("1", "A factor.", default=1.0), "__annotations__": {"factor": annotation}},
        )


def test_a_parameter_needs_its_declaration() -> None:
    with pytest.raises(TypeError, match=r"Wrong.factor must be .* = param"):
        type("Wrong", (Block,), {"factor": 1.0, "__annotations__": {"factor": float}})


# -- every block of the package ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", all_blocks().values(), ids=all_blocks())
def test_defaults_pass_their_own_checks_and_units_can_be_read(kind: type[Block]) -> None:
    made = kind()
    given = {name: getattr(made, name) for name in kind.parameters}
    assert kind(**given) == made
    for port in (*kind.inputs.values(), *kind.outputs.values()):
        assert unit(unit_of(made, port)).factor > 0
        assert port.doc.endswith(".")
    for parameter in kind.parameters.values():
        assert parameter.doc.endswith(".")
        assert parameter.kind in (str, bool) or unit(unit_of(made, parameter)).factor > 0


@block("V", voltage="V", threshold=param("V", "What is taken off.", default=0.1, at_least=0.0))
def rectified(p: Any, voltage: float) -> float:
    """Absolute value of a voltage, less a threshold."""
    return abs(voltage) - p.threshold


def test_a_block_of_one_function_with_a_parameter() -> None:
    made: Any = rectified
    assert made.__name__ == "Rectified"
    assert list(made.inputs) == ["voltage"]
    assert made.parameters["threshold"].unit == "V"
    assert drive(made(threshold=0.5), [{"voltage": -2.0}]) == [{"rectified": 1.5}]
    with pytest.raises(ModelError, match="must be >= 0"):
        made(threshold=-1.0)


def test_the_default_of_an_input_is_of_its_type() -> None:
    class Switched(Block):
        """Two inputs that may stay unconnected."""

        on = Input("1", "Whether it is on.", bool, default=True)
        level = Input("1", "How much.", default=2)

    assert [facts(Switched)["inputs"][name]["default"] for name in ("on", "level")] == [True, 2]
    with pytest.raises(TypeError, match=r"the default of an input of type bool must be True or False, not 1\.0"):
        Input("1", "Whether.", bool, default=1.0)
    with pytest.raises(TypeError, match="the default of an input of type float must be a number, not True"):
        Input("1", "How much.", default=True)


def test_a_parameter_of_a_block_cannot_be_deleted() -> None:
    mixer = Mixer()
    with pytest.raises(dataclasses.FrozenInstanceError, match="cannot delete depth"):
        del mixer.depth
    assert mixer.depth == 3
