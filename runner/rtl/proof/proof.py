"""Proof that Verilog does what the Python functions of its blocks do, for all inputs and all values
of the registers.

The proof compares the value of every register after the next clock, for any reset and enable, and
every output in an enabled clock. It assumes registers within their ranges, and proves that starts
and next values stay there; so they always are. Inputs are assumed within the ranges of their
drivers. For a pipeline the netlist is taken without the registers that only delay values;
`smt_pipeline` proves that all delays match.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from time import perf_counter

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.runner.fixed.integer_interval import Interval
from proofmass.runner.rtl.machine.modules import CLOCKING
from proofmass.runner.rtl.machine.reference import Reference, as_it_runs
from proofmass.runner.rtl.machine.words import Register, VerilogPort, Word
from proofmass.runner.rtl.proof.smt_cuts import Cuts
from proofmass.runner.rtl.proof.smt_implementation import Implementation, read_implementation
from proofmass.runner.rtl.proof.smt_integer import SmtInteger, Specification, conjunction
from proofmass.runner.rtl.proof.smt_pipeline import netlist_pipeline
from proofmass.runner.rtl.proof.smt_solver import Answer, SmtSolver, Term

_AT_ONCE = 0.3  # seconds for a goal as it stands, before cuts are tried
SECONDS = 30.0  # seconds for a goal in all


@dataclass(frozen=True)
class CounterExample:
    """Inputs and registers for which hardware and Python differ."""

    name: str  # of the output, or of the register after the clock
    stimulus: Mapping[str, int]
    python: str  # results of the functions run on it
    verilog: str
    late: int  # ticks by which the pipeline delays it

    def __str__(self) -> str:
        stimulus = ", ".join(f"{name} = {value}" for name, value in self.stimulus.items())
        later = f" {self.late} tick{'' if self.late == 1 else 's'} later" if self.late else ""
        return f"{self.name} is {self.python} in Python and {self.verilog} in Verilog{later} for {stimulus}"


@dataclass(frozen=True)
class Proof:
    """Result of the proof of a module or a machine."""

    name: str
    goals: int
    undecided: tuple[str, ...]
    faults: tuple[str, ...]  # of the pipeline: values with a wrong delay
    counter_examples: tuple[CounterExample, ...]
    seconds: float

    @property
    def proved(self) -> int:
        """Number of proved goals."""
        return self.goals - len(self.undecided) - len(self.faults) - len(self.counter_examples)


def prove(reference: Reference, verilog: str, guesses: Collection[Interval] = (), seconds: float = SECONDS) -> Proof:
    """Compare the module `reference.name` of a Verilog text with its reference; `seconds` is the
    limit for a goal.

    `guesses` are likely ranges of values. They help with hard goals, and are proved before they are
    used. Raises `ModelError` for a text that Yosys refuses, or that lacks a port or register of the
    reference.
    """
    began = perf_counter()
    sides = _Sides(reference, verilog, guesses)
    pipeline = sides.pipeline
    answers = [(goal, sides.answer(goal, seconds)) for goal in sides.goals if not pipeline.faults]
    return Proof(
        reference.name,
        len(answers) + pipeline.checks,
        tuple(goal.name for goal, answer in answers if answer.verdict == "undecided"),
        pipeline.faults,
        tuple(sides.counter_example(goal, a.values) for goal, a in answers if a.verdict == "refuted"),
        perf_counter() - began,
    )


@dataclass(frozen=True)
class _Goal:
    """A condition that must always hold; `implemented` is the term of the Verilog that it is about, if it is one."""

    name: str
    condition: str
    word: Word
    implemented: str = ""


class _Sides:
    """The two sides of a proof, and its goals."""

    def __init__(self, reference: Reference, verilog: str, guesses: Collection[Interval]) -> None:
        self.reference, self.guesses = reference, guesses
        self.implementation = read_implementation(verilog, reference.name)
        _check_names(reference, self.implementation)
        self.specification = Specification()
        self.held: dict[str, Word] = {port.name: port.word for port in reference.held}
        self.controls = CLOCKING[1:] if reference.clocked else ()
        bits = {name: self._bits(name, word) for name, word in self.held.items()}
        assumed = [bits[name].within(word.low, word.high) for name, word in self.held.items()]
        present = {n: self.specification.word(bits[n].text, word.low, word.high) for n, word in self.held.items()}
        self.goals = tuple(self._goals(present))
        self.solver = SmtSolver([*self.implementation.lines, *self.specification.lines])
        self.pipeline = netlist_pipeline(self.solver, self.implementation, reference)
        self.assumptions = [self.solver.read(term) for term in assumed]
        terms = self.implementation.terms
        self.steps = self.solver.read(f"(= {terms['enable']} #b1)" if reference.clocked else "true")
        self.stimulus = {n: self.solver.read(terms[n]) for n in (*self.controls, *self.held)}

    def answer(self, goal: _Goal, seconds: float) -> Answer:
        """Decide a goal, as it stands or with cuts."""
        shown = {**self.stimulus, **({"": self._read(goal.implemented)} if goal.implemented else {})}
        condition = self._read(goal.condition)
        answer = self.solver.prove(condition, self.assumptions, min(seconds, _AT_ONCE), shown)
        if answer.verdict == "undecided" and self._is_proved_with_cuts(condition, seconds):
            return Answer("proved", {})
        if answer.verdict == "undecided":
            answer = self.solver.prove(condition, self.assumptions, seconds, shown)
        return answer

    def _is_proved_with_cuts(self, condition: Term, seconds: float) -> bool:
        """Prove a goal separately for clocks with enable, by cuts, and for the simple others."""
        otherwise = [*self.assumptions, self.solver.make("NOT", self.steps)]
        shallow = self.solver.replaced(condition, self._cuts.replaced)
        cases = ((condition, otherwise), (shallow, self._cuts.known(shallow)))
        return all(self.solver.prove(each, known, seconds, {}).verdict == "proved" for each, known in cases)

    def counter_example(self, goal: _Goal, values: Mapping[str, int]) -> CounterExample:
        """Counterexample: inputs and registers with the results of Python and of the Verilog."""
        stimulus = {name: _read(values[name], self.held.get(name, _TRUTH)) for name in self.stimulus}
        verilog = str(_read(values[""], goal.word)) if goal.implemented else "not looked at"
        python = _replayed(self.reference, goal.name, stimulus)
        return CounterExample(goal.name, stimulus, python, verilog, self._late(goal.name, stimulus))

    def _late(self, name: str, stimulus: Mapping[str, int]) -> int:
        """Delay in ticks of an output, or of a register in a clock that steps."""
        if name not in self.pipeline.late:
            return self.reference.latency
        return self.pipeline.late[name] if stimulus["enable"] and not stimulus["reset"] else 0

    @cached_property
    def _cuts(self) -> Cuts:
        inputs = {self.stimulus[name]: word for name, word in self.held.items()}
        inputs |= {self.stimulus[name]: Word(value, value) for name, value in zip(self.controls, (0, 1), strict=False)}
        specified, implemented = self.specification.cuts, [self._read(name) for name in self.implementation.words]
        return Cuts(self.solver, [*self.assumptions, self.steps], inputs, specified, implemented, self.guesses)

    def _read(self, text: str) -> Term:
        """A term of the netlist without its pipeline."""
        return self.solver.replaced(self.solver.read(text), self.pipeline.transparent)

    def _bits(self, name: str, word: Word) -> SmtInteger:
        """A port or register of the Verilog as an integer of all values that its bits can have."""
        term = self.implementation.terms[name]
        if word.signed:
            return SmtInteger(self.specification, term, -(1 << (word.width - 1)), (1 << (word.width - 1)) - 1)
        return SmtInteger(self.specification, f"(concat #b0 {term})", 0, (1 << word.width) - 1)

    def _goals(self, present: Mapping[str, SmtInteger]) -> Iterator[_Goal]:
        clock = self.reference.clock(present, self.specification.merged)
        reset, enable = (
            (f"(= {self.implementation.terms[n]} #b1)" for n in self.controls) if self.controls else ("", "true")
        )
        for port in self.reference.outputs:
            value = self.specification.lift(clock.outputs[port.name])
            term = self.implementation.terms[port.name]
            equal = _equals(term, value.resized(port.word.width), value, port.word)
            yield _Goal(port.name, f"(=> {enable} {equal})", port.word, term)
        for register in self.reference.registers:
            value, word = self.specification.lift(clock.following[register.name]), register.word
            start, now = self.specification.constant(register.start), present[register.name]
            stepped, started, kept = (each.resized(word.width) for each in (value, start, now))
            after = f"(ite {reset} {started} (ite {enable} {stepped} {kept}))"
            term = self.implementation.following[register.name]
            yield _Goal(register.name, _equals(term, after, value, word), word, term)
        if self.specification.obligations:
            yield _Goal("what must fit its format", conjunction(self.specification.obligations), _TRUTH)


_TRUTH = Word(0, 1)


def _equals(term: str, other: str, value: SmtInteger, word: Word) -> str:
    """Words are equal, and the value that one is made of lies within its range."""
    return conjunction([f"(= {term} {other})", value.within(word.low, word.high)])


def _read(value: int, word: Word) -> int:
    return value - (1 << word.width) if word.signed and value >> (word.width - 1) else value


def _replayed(reference: Reference, name: str, stimulus: Mapping[str, int]) -> str:
    """Result of Python for inputs and registers: an output, or a register after the clock."""
    try:
        clock = reference.clock(stimulus, as_it_runs)
    except (ArithmeticError, TypeError, ValueError) as error:
        return str(error)
    if name in clock.outputs:
        return str(int(clock.outputs[name]))
    if stimulus.get("reset"):
        return str(next(each.start for each in reference.registers if each.name == name))
    after = clock.following if stimulus.get("enable") else stimulus
    return str(int(after[name])) if name in after else "within its format"


def _check_names(reference: Reference, implementation: Implementation) -> None:
    """Refuse a text without a port or register of the reference, or with other bits."""
    problems = []
    for kind, register in _declared(reference):
        width = (
            implementation.widths.get(register.name)
            if kind == "port" or register.name in implementation.following
            else None
        )
        if width != register.word.width:
            message, key = f"the Verilog has no such {kind}", f"{reference.name}.{register.name}"
            got, expected = f"{width} bits" if width else "nothing", f"{register.word.width} bits"
            problems.append(Problem(message=message, key=key, got=got, expected=expected))
    if problems:
        raise ModelError(problems)


def _declared(reference: Reference) -> Iterator[tuple[str, VerilogPort | Register]]:
    yield from (("port", each) for each in (*reference.inputs, *reference.outputs))
    yield from (("register", each) for each in reference.registers)
