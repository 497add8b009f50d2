"""A graph file that is watched: its last good model, what is wrong with it now, and what windows of it agree on."""

import math
import queue
import re
import threading
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any, TypeGuard

from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal
from proofmass.blocks.declaration.spelled_units import decimal_in
from proofmass.graphs.drawing.diagram import subgraph_paths, svg
from proofmass.graphs.model.changes import recording_of, with_parameters
from proofmass.graphs.model.flatten import parts
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.rates import read_duration
from proofmass.runner.live.long_run import Tell, long_run
from proofmass.runner.live.model import live_model
from proofmass.runner.live.saving import Saving
from proofmass.runner.live.tabs import TABS
from proofmass.runner.live.verdicts import verdicts
from proofmass.runner.run.faults import RunError

_SEED, _DURATION = re.compile(r"\d{1,18}"), re.compile(r"[0-9.eE+-]{1,40}( ?[a-zµμ]{1,5})?")
_MOST_CHANGES = 10_000
_MOST_TICKS = 10**12  # of a long run
_VERDICTS = "verdicts"  # a question without a tab
_LONGEST_TEXT = 100  # of an integer or a choice


Background = Callable[[Tell, threading.Event], None]  # tells windows how it goes on until the event


class Session:
    """A graph as its windows show it; `load` reads the graph anew and raises `ModelError`."""

    def __init__(
        self,
        path: Path,
        load: Callable[[], Graph],
        more_files: tuple[Path, ...] = (),
        study: Background | None = None,
        edit: bool = False,
    ) -> None:
        self.path, self._study = path, study
        self._saving = Saving(path) if edit else None
        self._changes: dict[str, int | str] = {}  # changes of parameters that need a new plan
        self._stops: dict[str, threading.Event] = {}  # of what runs in the background, by kind
        self._told: dict[str, dict[str, Any]] = {}  # how that stands
        self._long_wish: tuple[Any, ...] | None = None
        self._load, self._more = load, more_files
        self._graph: Graph | None = None
        self._shown: dict[str, Any] | None = None  # the last good model
        self._diagram: dict[str, Any] | None = None
        self._problems: list[dict[str, Any]] = []
        self._state: dict[str, Any] | None = None
        self._listeners: set[queue.SimpleQueue[dict[str, Any]]] = set()
        self._lock, self._computing, self._judging = threading.Lock(), threading.Lock(), threading.Lock()

    def reload(self) -> list[Problem]:
        """Read the graph, and show every window the new one, or what is wrong with it; returns the problems."""
        problems: list[Problem] = []
        graph, shown = self._graph, self._shown
        try:
            graph = with_parameters(self._load(), self._changes) if self._changes else self._load()
            tabs = [*TABS, *["study"] * (self._study is not None)]
            shown = {"kind": "graph", "model": live_model(graph), "tabs": tabs}
            shown["undo"] = None if self._saving is None else len(self._saving)
            shown["changes"] = {name: str(value) for name, value in self._changes.items()}
        except ModelError as error:
            problems = list(error.problems)
        except OSError as error:
            problems = [Problem(message=f"cannot be read: {error.strerror}", file=str(self.path))]
        with self._lock:
            self._problems = [problem.as_data() for problem in problems]
            if not problems:
                self._graph, self._shown = graph, shown
            self._tell(shown if shown and not problems else {"kind": "problems", "problems": self._problems})
        if not problems and graph is not None:
            diagram = {"kind": "diagram", "svg": svg(graph)}  # after the traces people wait for
            with self._lock:
                self._diagram = diagram
                self._tell(diagram)
                if self._study is not None:
                    self._begin("study", self._study)
        return problems

    def change(self, data: object) -> bool:
        """Put integers and choices into the graph, and show windows the new one; False if bad."""
        changes = data.get("changes") if isinstance(data, dict) else None
        if not isinstance(changes, dict) or self._shown is None:
            return False
        known = {_name(fixed): fixed for fixed in self._shown["model"]["fixed"] if fixed["whole"] or fixed["choices"]}
        read: dict[str, int | str] = {}
        for name, text in changes.items():
            fixed = known.get(name)
            if fixed is None or not isinstance(text, str) or len(text) > _LONGEST_TEXT:
                return False
            read[name] = _value(fixed, text)
        before, self._changes = self._changes, read
        if self.reload():
            self._changes = before
        return True

    def drawing(self, data: object) -> dict[str, Any] | None:
        """The diagram with subgraphs unfolded, all for a star; None if `question` is malformed."""
        paths = data.get("unfolded") if isinstance(data, dict) else None
        if not isinstance(paths, list) or self._graph is None:
            return None
        known = subgraph_paths(self._graph)
        wanted = known if paths == ["*"] else [path for path in paths if path in known]
        return {"svg": svg(self._graph, wanted)}

    def long(self, data: object) -> bool:
        """Begin a run that is too long for a page, unless one is running; return False if `data` is malformed."""
        state = read_state(data)
        ticks, pixels = (data.get(key) if isinstance(data, dict) else None for key in ("ticks", "pixels"))
        if state is None or self._graph is None or not _is_count(ticks) or not _is_count(pixels):
            return False
        graph = self._graph

        def run(tell: Tell, stop: threading.Event) -> None:
            try:
                changed = with_parameters(graph, state["values"]) if state["values"] else graph
                long_run(changed, ticks, int(state["seed"]), pixels, tell, stop)
            except ModelError as error:
                tell({"problems": [problem.as_data() for problem in error.problems]})

        with self._lock:
            wish = self._shown, state, ticks
            if self._long_wish == wish:
                if "long" in self._told:
                    self._tell(self._told["long"])
                return True
            self._long_wish = wish
            self._told.pop("long", None)
            self._begin("long", run, state=state)
        return True

    def end(self) -> None:
        """End what runs in the background."""
        for stop in self._stops.values():
            stop.set()

    def _begin(self, kind: str, work: Background, **of: Any) -> None:
        """Begin work in the background, in place of that of its kind. The caller holds the lock."""
        if kind in self._stops:
            self._stops[kind].set()
        stop = self._stops[kind] = threading.Event()

        def tell(message: dict[str, Any]) -> None:
            with self._lock:
                if not stop.is_set():
                    self._told[kind] = {"kind": kind, **of, **message}
                    self._tell(self._told[kind])

        threading.Thread(target=work, args=(tell, stop), daemon=True).start()

    def files(self) -> tuple[Path, ...]:
        """The files that the graph is read from, as it was when it was last right."""
        named = _files(self._graph) if self._graph else ()
        return tuple(dict.fromkeys((self.path, *self._more, *named)))

    def listen(self) -> "queue.SimpleQueue[dict[str, Any]]":
        """A queue of what a new window is told, from how things stand on."""
        heard: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        with self._lock:
            problems = {"kind": "problems", "problems": self._problems} if self._problems else None
            state = {"kind": "state", "state": self._state, "window": ""} if self._state else None
            for message in (self._shown, self._diagram, problems, self._told.get("study"), state):
                if message:
                    heard.put(message)
            self._listeners.add(heard)
        return heard

    def leave(self, heard: "queue.SimpleQueue[dict[str, Any]]") -> None:
        """Tell a window no more."""
        with self._lock:
            self._listeners.discard(heard)

    def set_state(self, data: object) -> bool:
        """Take what one window has set, tell the others; return False if it is not a state."""
        state = read_state(data)
        if state is None or not isinstance(data, dict):
            return False
        with self._lock:
            self._state = state
            self._tell({"kind": "state", "state": state, "window": str(data.get("window", ""))[:40]})
        return True

    def answer(self, question: str, data: object) -> dict[str, Any] | None:
        """The answer of a tab, or the verdicts, for the run as a window has it; None if the question is malformed."""
        state = read_state(data)
        if state is None or self._graph is None or question not in (*TABS, _VERDICTS):
            return None
        thorough = isinstance(data, dict) and data.get("thorough") is True
        with self._judging if question == _VERDICTS and not thorough else self._computing:
            try:
                graph = with_parameters(self._graph, state["values"]) if state["values"] else self._graph
                length = read_duration(state["duration"])
                graph = graph.changed(seed=int(state["seed"]), duration=length, samples=None)
                if question == _VERDICTS:
                    return verdicts(graph, thorough)._asdict()
                return TABS[question](graph)._asdict()
            except ModelError as error:
                return {"problems": [problem.as_data() for problem in error.problems]}
            except (RunError, Refusal) as error:
                return {"problems": [Problem(message=str(error)).as_data()]}

    def save(self, data: object) -> dict[str, Any] | None:
        """Write the values of the sliders into the file; None if they are malformed, or where
        nothing may be written.

        Of what a browser sends only numbers are taken: names and units are those of the graph.
        """
        state = read_state(data)
        if state is None or self._saving is None or self._shown is None:
            return None
        known = {_name(one): one for one in self._shown["model"]["sliders"]}
        if not state["values"].keys() <= known.keys():
            return None
        texts = {name: quantity(known[name], value) for name, value in state["values"].items()}
        saving = self._saving
        return self._written(lambda: saving.save({**self._changes, **texts}))

    def undo(self, data: object) -> dict[str, Any] | None:
        """Take back the last save; None where nothing may be written."""
        return self._written(self._saving.undo) if self._saving is not None and isinstance(data, dict) else None

    def _written(self, write: Callable[[], None]) -> dict[str, Any]:
        try:
            write()
        except ModelError as error:
            return {"problems": [problem.as_data() for problem in error.problems]}
        except OSError as error:
            problem = Problem(message=f"cannot be edited in place: {error.strerror}", file=str(self.path))
            return {"problems": [problem.as_data()]}
        with self._lock:
            self._changes = {}  # the file has them
            if self._state:
                self._state = {**self._state, "values": {}}
        return {"undo": len(self._saving or ())}

    def _tell(self, message: dict[str, Any]) -> None:
        for heard in self._listeners:
            heard.put(message)


def read_state(data: object) -> dict[str, Any] | None:
    """The controls as a window describes them: numbers by parameter, seed and duration; None for anything else."""
    state = data.get("state") if isinstance(data, dict) else None
    if not isinstance(state, dict):
        return None
    values, seed, duration = (state.get(key) for key in ("values", "seed", "duration"))
    if not isinstance(values, dict) or len(values) > _MOST_CHANGES or not all(map(_is_number, values.values())):
        return None
    forms = (seed, _SEED), (duration, _DURATION)
    if not all(isinstance(text, str) and form.fullmatch(text) for text, form in forms):
        return None
    return {"values": {name: float(value) for name, value in values.items()}, "seed": seed, "duration": duration}


def quantity(slider: Mapping[str, Any], value: float) -> float | str:
    """Return a slider's value as the file has it: a number, or a text with its unit there."""
    top, bottom = slider["factor"]
    number = decimal_in(value, Fraction(int(top), int(bottom)))
    return value if slider["shown"] == "1" else f"{number} {slider['shown']}"


def _name(fixed: Mapping[str, Any]) -> str:
    return f"{fixed['block']}.{fixed['parameter']}" if fixed["block"] else str(fixed["parameter"])


def _value(fixed: Mapping[str, Any], text: str) -> int | str:
    """The value that a text stands for, or the text itself, which the graph then refuses."""
    if fixed["whole"]:
        return int(text) if re.fullmatch(r"[+-]?\d{1,18}", text) else text
    return text == "true" if fixed["choices"] == ("false", "true") and text in fixed["choices"] else text


def _is_count(value: object) -> TypeGuard[int]:
    return isinstance(value, int) and not isinstance(value, bool) and 0 < value <= _MOST_TICKS


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _files(graph: Graph) -> Iterator[Path]:
    """The file of a graph, those of its parts, and the recordings that they play."""
    for _, part in parts(graph):
        if part.place.file:
            yield Path(part.place.file)
        for block in part.blocks.values():
            if file := recording_of(block):
                yield Path(part.place.folder) / file
