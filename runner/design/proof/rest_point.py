"""The point of rest, or the orbit, of every sensor of a box, enclosed by Krawczyk's operator.

With the map F(x, q) of all that a graph remembers, a sensor q rests at x = F(x, q), which
`enclosed` encloses. Where carriers or switches come round after N periods, x has what is remembered
at the start of each of them, and F moves each of these by its own period:

    F(x_1, ..., x_N) = (F_N(x_N), F_1(x_1), ..., F_N-1(x_N-1))

so that an orbit is a point of rest of F, and one period after the other is enclosed (multiple shooting). It lies near
a polynomial c(q), the last of the steps

    c <- c + R (F(c, q) - c),   R near (I - J)^-1 in the middle of the box

F is that of ideal converters, without noise, with sources that are constant, or come round, from
the operating point on. It is of a tick in which all blocks compute, or of whole periods
(`rest_ticks`).
"""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from proofmass.graphs.model.graph import split
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.linearisation import Linearisation
from proofmass.runner.analysis.linearisation.orbit import OrbitPoint
from proofmass.runner.derivatives.ball import Ball, UndecidedError, arb_of, double_of, enclosing
from proofmass.runner.derivatives.dual import plain
from proofmass.runner.derivatives.polynomial import PolynomialBall, model_of
from proofmass.runner.derivatives.taylor_model import TaylorModel, order_kept
from proofmass.runner.design.proof.about_rest import AboutRest
from proofmass.runner.design.proof.ball_ticks import with_balls
from proofmass.runner.design.proof.enclosed import Enclosed, RestPoint, balls_of, near_inverse
from proofmass.runner.design.proof.places import Image, along_curves, entries_of, neutral, put_back, tangents
from proofmass.runner.design.proof.rest_maps import RestMaps, not_at_rest
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.planned import Plan

_NEWTON, _WIDENED, _NEAR = 12, 16, 1e-13  # steps at most, and part of a number that ends Newton's
_STEPS, _MOST_STEPS, _FOLLOWED = (1, 2, 4, 8), 16, 0.75  # of parameters, and how far R may turn in one of Newton's
_CLOSE, _LEAST = 1e-15, 1e-50  # reaches at least: part of a number, and beside zero
_FARTHEST = 1e30  # beyond which no reach is tried
_NOWHERE = "no point of rest is enclosed: something on the way does not settle, or bends too much"
_ROOM, _SPARE = 1.3, 1.15  # how much further than needed a reach is, at least
_ROUNDS, _STILL = 3, 1e-9  # of curves of places that move on, and how far one may that stays


class RestRun(RestMaps):
    """Points of rest or orbits of the sensors of a plan, as far as outputs depend on them."""

    def enclosed(self, parameters: Mapping[str, Any]) -> RestPoint:
        """Return where all sensors with such parameters rest; raises `UndecidedError` where that is not shown."""
        plan = with_balls(self._plan, parameters)
        places = self._values_of(parameters)
        if not self._comes_round(plan):
            raise UndecidedError("a source changes with time for some parameters")
        if self.places and not self.directions:
            raise UndecidedError(f"{self.places[0].name} comes to no rest")
        if not self.directions:
            empty = Enclosed.exact(np.zeros((0, 0)))
            return RestPoint([], np.zeros(0), empty.middle[0], empty, empty)
        centre, left, begin = self._in_the_middle({name: double_of(value)[0] for name, value in parameters.items()})
        curve, along = [_exact(x) for x in centre.tolist()], begin.tolist()
        steps = order_kept(len(parameters)) if parameters else 0
        for number in range(_ROUNDS if self.places and steps else 1):
            if number:
                image = self.image(plan, curve, places)
                if not any(abs(double_of(plain(x))[0]) > _STILL for x in image.passed):
                    break
                along = entries_of(along_curves(model_of(self._slopes(image)), along, left))
            for _ in range(steps):
                after = put_back(self.image(plan, curve, places, seeded=False), along)
                apart = model_of([[plain(x) - c] for x, c in zip(after, curve, strict=True)])
                by = TaylorModel.constant(left) @ apart
                curve = [(PolynomialBall(by[i, 0]) + c).middles for i, c in enumerate(curve)]
        return self._around(plan, curve, places, left, along)

    def _values_of(self, parameters: Mapping[str, Any]) -> list[Any]:
        """Return numbers of the places: those among parameters, else the nominal ones."""
        return [parameters.get(p.name, _exact(p.range.nominal)) for p in self.places]

    def _in_the_middle(self, parameters: Mapping[str, float]) -> tuple[Array, Array, Array]:
        """Return about where a sensor rests, R, and how it moves with its places.

        From where the run rests parameters go there in as few steps as Newton's method follows.
        """
        begin = {name: self._nominal(name) for name in (*parameters, *(place.name for place in self.places))}
        end = {place.name: place.range.nominal for place in self.places} | dict(parameters)
        for steps in _STEPS:
            with suppress(UndecidedError):
                return self._followed(begin, end, steps)
        return self._followed(begin, end, _MOST_STEPS)

    def _nominal(self, name: str) -> float:
        """Return what the run has for a parameter or a place."""
        place = next((place for place in self.places if place.name == name), None)
        if place is not None:
            return place.nominal
        block, parameter = split(name)
        return float(getattr(self._begun.blocks[block], parameter))

    def _followed(self, begin: Mapping[str, float], end: Mapping[str, float], steps: int) -> tuple[Array, Array, Array]:
        """Return where some steps lead; raises `UndecidedError` where Newton's method does not follow them."""
        centre, along, left, before = np.array(self._start), self._along, self._begun_left, dict(begin)
        for step in range(1, steps + 1):
            now = {name: begin[name] + (value - begin[name]) * (step / steps) for name, value in end.items()}
            apart = [0.0 if place.turns else now[place.name] - before[place.name] for place in self.places]
            if any(apart):
                centre = centre + along @ apart
            centre, left, along = self._newton(now, centre, along, left)
            before = now
        return centre, left, along

    @cached_property
    def _begun_left(self) -> Array:
        """R where the run rests."""
        own, places = RestRun.like(self, self._begun), {place.name: place.nominal for place in self.places}
        return own._newton(places, np.array(self._start), self._along, None)[1]

    def _newton(
        self, parameters: Mapping[str, float], centre: Array, along: Array, known: Array | None
    ) -> tuple[Array, Array, Array]:
        """Return about where a sensor rests, by Newton's method, R, and how it moves with its places.

        Raises `UndecidedError` where R, if it is `known` at another sensor, leaps on the way from there.
        """
        numbers = {name: _exact(value) for name, value in parameters.items()}
        plan, places = with_balls(self._plan, numbers), self._values_of(numbers)
        sizes, before, left = np.abs(centre), np.full(len(centre), math.inf), np.eye(len(centre))
        for _ in range(_NEWTON):
            image = self.image(plan, balls_of(centre), places)
            if self.places:
                along = self._along_there(image)
            after = put_back(image, along.tolist())
            left = near_inverse(self._matrix(after))
            if known is not None and not _turned(left, known) <= _FOLLOWED:
                raise UndecidedError(_NOWHERE)
            known = known if known is None else left
            by = left @ np.array([double_of(plain(x))[0] for x in after] - centre)
            if not np.isfinite(by).all():
                break
            centre, sizes = centre + by, np.maximum(sizes, np.abs(by))
            if bool(((np.abs(by) <= _NEAR * sizes) | (np.abs(by) >= 0.5 * before)).all()):  # or rounding is left
                break
            before = np.abs(by)
        return centre, left, along

    def _along_there(self, image: Image) -> Array:
        """Return how all that moves would move with its places; raises `UndecidedError` where that is not told."""
        slopes = [[double_of(value)[0] for value in row] for row in self._slopes(image)]
        chosen = range(len(self.directions), len(slopes))
        return neutral(np.array(slopes), chosen)[1]

    def map_between(self, ends: Ends) -> OrbitPoint:
        """Return the map between some ends about the point of rest of the sensor as it is; raises `ModelError`."""
        return self.linearised(self._plan).point_of(ends)

    def _around(
        self, plan: Plan, curve: Sequence[Any], places: Sequence[Any], left: Array, along: Sequence[Sequence[Any]]
    ) -> RestPoint:
        after = put_back(self.image(plan, curve, places, seeded=False), along)
        apart = [[plain(x) - c] for x, c in zip(after, curve, strict=True)]
        step = Enclosed.of_balls([apart])
        point = RestPoint(curve, np.zeros(len(curve)), left, step, step)
        for _ in range(_WIDENED):
            image = self.image(plan, point.values, places)
            point = replace(point, matrix=Enclosed.of_balls([self._matrix(put_back(image, along))]))
            if _fits(point):
                return self._with_places(point, image, places, along)
            for _ in range(_WIDENED):  # with these slopes
                if not bool((point.reach <= _FARTHEST).all()):
                    raise UndecidedError(_NOWHERE)
                if _fits(point):
                    break
                point = _wider(point)
        raise UndecidedError(_NOWHERE)

    def _with_places(
        self, point: RestPoint, image: Image, places: Sequence[Any], along: Sequence[Sequence[Any]]
    ) -> RestPoint:
        """Return a point with its places and how it moves with them; raises `UndecidedError` where that is not slow."""
        if not self.places:
            return point
        for place, moved in zip(self.places, image.passed, strict=True):
            place.check(max(map(abs, Ball(arb_of(plain(moved))).ends())))
        return replace(point, places=places, along=tangents(model_of(self._slopes(image)), along, point.left))

    def value(self, plan: Plan) -> tuple[float, float]:
        """Return the first output of a plan with other parameters at rest, and what it may be off;
        raises `ModelError`.

        It is that of ideal converters.
        """
        own = RestRun.like(self, plan)
        rest = own._own_point({})
        with enclosing():
            outputs = own.image(plan, rest.values, rest.places).outputs
            low, high = Ball(sum(arb_of(plain(value)) for value in outputs) / len(outputs)).ends()
        return 0.5 * low + 0.5 * high, high - low

    def _own_point(self, places: Mapping[str, float]) -> RestPoint:
        """Return where the sensor as it is rests, with some of its places; raises `ModelError`."""
        try:
            with enclosing():
                return self.enclosed({name: _exact(x) for name, x in {**self._moved(), **places}.items()})
        except UndecidedError as error:
            raise self._plan.graph.placed(not_at_rest(str(error), self._signal)).error from None

    def _moved(self) -> dict[str, float]:
        """Return the parameters, a number each, that are not those of the run."""
        pairs = ((name, block, self._begun.blocks[name]) for name, block in self._plan.blocks.items())
        both = (
            (f"{name}.{parameter}", getattr(block, parameter), getattr(begun, parameter))
            for name, block, begun in pairs
            for parameter in type(block).parameters
        )
        return {name: value for name, value, before in both if isinstance(value, float) and value != before}

    def linearised(self, plan: Plan, places: Mapping[str, float] | None = None) -> Linearisation:
        """Return a plan with other parameters about its own point of rest, at some places; raises `ModelError`."""
        own = RestRun.like(self, plan)
        rest = own._own_point(places or {})
        numbers = [double_of(place)[0] for place in rest.places]
        there = own.memory_of(plan, rest.centre.tolist(), numbers, seeded=False)
        told = "on an orbit" if self.orbit else "at rest"
        least = own._ticks * own.periods if self.orbit else 1
        along = {
            place.entry: {e: double_of(row[k])[0] for e, row in zip(own.entries, rest.along, strict=True)}
            for k, place in enumerate(own.places)
        }
        return AboutRest(plan, own.course, own.tick, told, memory_there=there, least=least, along=along)

    @classmethod
    def like(cls, other: "RestRun", plan: Plan) -> "RestRun":
        """Return points of rest of a plan with other parameters, begun where another begins."""
        own = object.__new__(cls)
        vars(own).update(vars(other) | {"_plan": plan})
        return own


def _exact(number: float) -> PolynomialBall:
    """Return a number as one that follows coordinates, which no converter rounds."""
    return PolynomialBall(TaylorModel.constant(number))


def _turned(left: Array, before: Array) -> float:
    """Return how far R is from what it was: from one on, two points of rest may have met on the way."""
    try:
        return float(np.max(np.abs(np.linalg.eigvals(np.linalg.solve(left, before)) - 1.0)))
    except np.linalg.LinAlgError:  # it is not finite, or has no inverse
        return math.inf


def _fits(point: RestPoint) -> bool:
    return bool((point.needed() * _SPARE < point.reach).all())


def _wider(point: RestPoint) -> RestPoint:
    reach = np.maximum(_ROOM * point.needed(), point.reach)
    return replace(point, reach=reach + _CLOSE * np.abs(point.centre) + _LEAST)
