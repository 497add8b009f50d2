"""Pipelines in the netlist of a proof: which registers only make values late, by how many ticks
each register and output is late, and the netlist without them.

Nothing of the tracer is asked, only what Yosys read in the text. A netlist of latency L has to give
in the n-th enabled clock after a reset, counted from 0 and for all n >= L, what Python gives in
tick n - L. The inputs of a tick are those of the clock of its number. What outputs are before is
not said. It is shown in two parts.

Here, of the registers, those of the blocks and those that were added to them:

- Timers are added registers that depend on reset, enable and each other alone. They are run from a reset on, which
  gives c(0), c(1), ... until they rest. All other added registers are those of the pipeline.
- D(x) is what a register x takes where reset is off, enable is on and the timers rest.
- Where reset and enable are off every register keeps its value, so that enabled clocks alone count. Under reset timers
  and registers of the blocks take constants, whatever was before.
- Each register has a stage, and so has what it takes; inputs have stage 0. That of a register r of a block is the first
  n from which on it takes D(r) with c(n), c(n + 1), ...; before, it keeps its value. All that D(r)
  depends on has the stage of r. All that D(p) of a register of the pipeline depends on has one
  stage k, from c(k) on p takes D(p), and
  its own stage is k + 1. All that an output depends on has stage L.

By the solver, of the netlist in which D(p) is in the place of p, down to inputs and registers of
the blocks: outputs and every D(r) are what Python makes of inputs and registers, for all of them;
constants under reset are the starts.

So a value of stage k is in clock n >= k what that netlist makes of inputs and registers of tick n -
k. By induction over n, and in a clock over operations, whose operands have one stage: of inputs it
is said so. p holds D(p) of clock n - 1, which has stage k - 1: that of tick n - k. r holds its
start up to clock k, and since then has taken D(r) of ticks 0 to n - k - 1, which are the values
that Python gives it.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from graphlib import CycleError, TopologicalSorter
from itertools import islice

from proofmass.runner.rtl.machine.modules import CLOCKING
from proofmass.runner.rtl.machine.reference import Reference
from proofmass.runner.rtl.proof.smt_implementation import Implementation
from proofmass.runner.rtl.proof.smt_solver import SmtSolver, Term, constants_of

_MOST_CLOCKS = 1000  # until timers have come to rest


@dataclass(frozen=True)
class PipelineFindings:
    """Findings: `transparent` has the terms to put in the place of timers and registers of the
    pipeline, `late` the stages of the blocks' registers, by name.

    `checks` counts the registers and outputs that were looked at, `faults` says what is wrong with
    them.
    """

    transparent: Mapping[Term, Term]
    late: Mapping[str, int]
    checks: int
    faults: tuple[str, ...]


def netlist_pipeline(solver: SmtSolver, implementation: Implementation, reference: Reference) -> PipelineFindings:
    """The pipeline of a netlist whose outputs are to be `reference.latency` late."""
    netlist = _Netlist(solver, implementation, reference)
    if not netlist.added and not reference.latency:
        return PipelineFindings({}, {}, 0, ())
    checks = len(netlist.following) + len(reference.outputs)
    try:
        faults = tuple(netlist.faults())
    except _NoStagesError as fault:
        faults = (str(fault),)
    if faults:
        return PipelineFindings({}, {}, checks, faults)
    return PipelineFindings(netlist.transparent, netlist.late, checks, ())


class _NoStagesError(Exception):
    """Fault of a pipeline whose registers have no stages."""


class _Netlist:
    """Registers as constants of the solver, and what they take."""

    def __init__(self, solver: SmtSolver, implementation: Implementation, reference: Reference) -> None:
        self.solver, self.latency = solver, reference.latency
        named = [*implementation.following, *(port.name for port in reference.held), *CLOCKING]
        constants = {n: constants_of(solver.read(implementation.terms[n])) for n in named if n in implementation.terms}
        self.following = {solver.read(name): solver.read(term) for name, term in implementation.moves.items()}
        self.own = {bit: register.name for register in reference.registers for bit in constants[register.name]}
        self.added = [term for term in self.following if term not in self.own]
        self.outputs = {port.name: solver.read(implementation.terms[port.name]) for port in reference.outputs}
        self._clocking = {name: term for name in CLOCKING[1:] for term in constants.get(name, ())}
        self._names = {term: name for name, terms in constants.items() for term in terms}

    # -- parts -------------------------------------------------------------------------------------

    @cached_property
    def timers(self) -> list[Term]:
        """Added registers that depend on reset, enable and each other alone."""
        restarted = self._given(reset=True)
        restarting = {
            register for register in self.added if self._value(self.following[register], restarted) is not None
        }
        depends = {register: set(self._leaves(self.following[register])) for register in restarting}
        while others := {register for register in restarting if not depends[register] <= restarting}:
            restarting -= others
        return [register for register in self.added if register in restarting]

    @cached_property
    def cuts(self) -> list[Term]:
        """Registers that make values late."""
        timers = set(self.timers)
        return [each for each in self.added if each not in timers]

    @cached_property
    def phases(self) -> list[dict[Term, Term]]:
        """The timers in enabled clocks after a reset, until they stay as they are."""
        phases = [self._timers(self._given(reset=True))]
        while len(phases) < 2 or phases[-1] != phases[-2]:
            if len(phases) > _MOST_CLOCKS:
                raise _NoStagesError(f"{self._name(self.timers[0])} does not rest {_MOST_CLOCKS} clocks after a reset")
            phases.append(self._timers(self._stepping(phases[-1])))
        return phases[:-1]

    @cached_property
    def taken(self) -> dict[Term, Term]:
        """D of every register but the timers."""
        return {each: self._in_phase(each, self.phases[-1]) for each in (*self.cuts, *self.own)}

    @cached_property
    def begins(self) -> dict[Term, int]:
        """The first enabled clock after a reset from which on a register takes D."""
        begins = {}
        for register, taken in self.taken.items():
            others = [n for n, phase in enumerate(self.phases) if self._in_phase(register, phase) != taken]
            begins[register] = max(others, default=-1) + 1
        return begins

    @cached_property
    def stages(self) -> dict[Term, int]:
        """Stages of the registers; raises _NoStagesError for a loop of its registers."""
        stages = {register: self.begins[register] for register in self.own}
        for register in self._ordered():
            leaves = self._leaves(self.taken[register])
            stages[register] = 1 + max((stages.get(each, 0) for each in leaves), default=self.begins[register])
        return stages

    @property
    def late(self) -> dict[str, int]:
        """The stages of the blocks' registers by name."""
        return {name: self.stages[register] for register, name in self.own.items()}

    @cached_property
    def transparent(self) -> dict[Term, Term]:
        """Resting values of the timers, and D of the registers of the pipeline, down to registers outside it."""
        found = dict(self.phases[-1])
        for register in self._ordered():
            found[register] = self.solver.replaced(self.taken[register], found)
        return found

    # -- faults ------------------------------------------------------------------------------------

    def faults(self) -> Iterator[str]:
        """Yield the first fault of each register and output."""
        for found in (*map(self._of_register, self.following), *map(self._of_output, self.outputs)):
            yield from islice(found, 1)

    def _of_register(self, register: Term) -> Iterator[str]:
        name = self._name(register)
        if not self._is_kept(register):
            yield f"{name} moves in clocks without enable"
        if register in self.own:
            yield from self._of_own(register, name)
        elif register in self.stages:
            stage, begins = self.stages[register] - 1, self.begins[register]
            yield from self._out_of_step(name, self.taken[register], stage)
            if begins > stage:
                yield f"{name} waits {_ticks(begins)} for what is {_ticks(stage)} late"

    def _of_own(self, register: Term, name: str) -> Iterator[str]:
        if self._value(self.following[register], self._given(reset=True)) is None:
            yield f"{name} has no start of its own under reset"
        yield from self._out_of_step(name, self.taken[register], self.stages[register])
        if any(self._in_phase(register, phase) != register for phase in self.phases[: self.begins[register]]):
            yield f"{name} moves before the first values are there"

    def _of_output(self, name: str) -> Iterator[str]:
        enabled = self._given(enable=True)
        phases = [self.solver.replaced(self.outputs[name], {**enabled, **phase}) for phase in self.phases]
        yield from self._out_of_step(name, phases[-1], self.latency)
        if any(each != phases[-1] for each in phases[self.latency :]):
            yield f"{name} is given by other operations when its first values come"

    def _out_of_step(self, name: str, term: Term, stage: int) -> Iterator[str]:
        """Yield the fault of a term all of whose registers and inputs should have one stage."""
        leaves = sorted(self._leaves(term), key=self._name, reverse=True)
        late = {self.stages.get(each, 0): self._name(each) for each in leaves}
        texts = [f"{late[each]}, {_ticks(each)} late" for each in sorted(late)]
        if len(late) > 1:
            yield f"{name} is made of {texts[0]}, and {texts[-1]}"
        elif late and stage not in late:
            yield f"{name} is to be {_ticks(stage)} late and is made of {texts[0]}"

    def _is_kept(self, register: Term) -> bool:
        given = [{**self._given(reset=False, enable=False), **phase} for phase in self.phases]
        if register in self.phases[0]:
            return all(self._value(self.following[register], each) == each[register] for each in given)
        return all(self._chosen(register, each) == register for each in given)

    # -- terms -------------------------------------------------------------------------------------

    def _ordered(self) -> Iterable[Term]:
        """Registers of the pipeline, each behind those that it depends on; raises _NoStagesError for a loop."""
        cuts = set(self.cuts)
        before = {cut: [leaf for leaf in self._leaves(self.taken[cut]) if leaf in cuts] for cut in self.cuts}
        try:
            return list(TopologicalSorter(before).static_order())
        except CycleError as error:
            loop = " -> ".join(self._name(cut) for cut in error.args[1])
            raise _NoStagesError(f"a loop of registers of the pipeline: {loop}") from None

    def _leaves(self, term: Term) -> list[Term]:
        """The registers and inputs that a term depends on."""
        return [each for each in constants_of(term) if each not in self._clocking.values()]

    def _stepping(self, phase: Mapping[Term, Term]) -> dict[Term, Term]:
        return {**self._given(reset=False, enable=True), **phase}

    def _given(self, **values: bool) -> dict[Term, Term]:
        """Return what to put in the place of reset and enable."""
        constants = ((self._clocking[name], value) for name, value in values.items())
        return {each: self.solver.truth(value, each) for each, value in constants}

    def _timers(self, given: Mapping[Term, Term]) -> dict[Term, Term]:
        return {each: self._value(self.following[each], given) for each in self.timers}

    def _in_phase(self, register: Term, phase: Mapping[Term, Term]) -> Term:
        return self._chosen(register, self._stepping(phase))

    def _chosen(self, register: Term, given: Mapping[Term, Term]) -> Term:
        return self.solver.chosen(self.solver.replaced(self.following[register], given))

    def _value(self, term: Term, given: Mapping[Term, Term]) -> Term | None:
        value = self.solver.simplified(self.solver.replaced(term, given))
        return value if value.is_value() else None

    def _name(self, term: Term) -> str:
        return self._names.get(term, str(term))


def _ticks(number: int) -> str:
    return f"{number} tick{'' if number == 1 else 's'}"
