"""Drift of a parameter over the epochs of a study: laws of ageing, evaluated at an age instead of simulated.

d(t) = ramp t + w(t) + logarithmic log10(1 + t / onset) + arrhenius t exp(E / k (1 / T0 - 1 / T)) +
cycles n(t)

With a mission, the temperature is its history, and n(t) the number of cycles of a reference range
that wear as much.

w is a random walk with standard deviation `random_walk` sqrt(t). The paces of one sensor differ
from those of another by normal deviates of the stated spread. The laws are those of the blocks
DriftRamp, RandomWalk, LogarithmicAgeing and ArrheniusAgeing.
"""

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType
from typing import Any

from proofmass.blocks.arithmetic.counter_random import normal_deviate
from proofmass.blocks.declaration.problem import Refusal, did_you_mean, shown
from proofmass.blocks.noise_and_drift import arrhenius_ageing, logarithmic_ageing
from proofmass.graphs.studies.missions import Mission
from proofmass.graphs.studies.table_entries import checked_table, read_flag, read_quantity

WALK = "random_walk"
LAWS = ("ramp", WALK, "logarithmic", "arrhenius", "cycles")
_FIRST_STEP = 4  # of the random walk, among the deviates of a parameter
_SPREAD = {f"{law}_spread": f"Standard deviation of {law} from sensor to sensor." for law in LAWS if law != WALK}
DRIFT_KEYS = {
    "ramp": 'Change per time: "20 ppm/year".',
    "random_walk": 'Standard deviation after a time: "5 ppm/sqrt(year)".',
    "logarithmic": "Change per factor of ten in age, from the onset on.",
    "arrhenius": 'Change per time at the reference temperature, "10 ppm/year", sped up by the temperature.',
    "cycles": "Change per cycle of temperature of the reference range, of a mission.",
    **_SPREAD,
    "onset": "Age at which the logarithm sets in, 1 d when nothing is said.",
    "temperature": "Temperature at which the sensor is kept, 298.15 K when nothing is said.",
    "reference_temperature": "Temperature of the stated pace, 298.15 K when nothing is said.",
    "activation_energy": "0.7 eV when nothing is said.",
    "mission": "Temperatures that the sensor goes through, by the name of a mission of the study.",
    "cycle_range": "Range of a cycle that changes the parameter by `cycles`, 100 K when nothing is said.",
    "cycle_exponent": "Power of the range by which other cycles change it, 2 when nothing is said.",
    "relative": "true: changes are relative to the value of the graph.",
}
NEEDED_BY = {
    "onset": "logarithmic",
    "temperature": "arrhenius",
    "reference_temperature": "arrhenius",
    "activation_energy": "arrhenius",
    "cycle_range": "cycles",
    "cycle_exponent": "cycles",
    **{key: key.removesuffix("_spread") for key in _SPREAD},
}
NO_MISSIONS: Mapping[str, Mission] = MappingProxyType({})
_NUMBERS = {  # settings beside the laws: unit, least value
    "onset": ("s", 1e-3),
    "temperature": ("K", 1.0),
    "reference_temperature": ("K", 100.0),
    "activation_energy": ("J", 0.0),
    "cycle_range": ("K", 1e-3),
    "cycle_exponent": ("1", 0.0),
}
_LATER = ("cycles", "cycles_spread", "cycle_range", "cycle_exponent", "mission", "history")  # not written by default


@dataclass(frozen=True, repr=False)
class Drift:
    """The laws by which one parameter ages, in its unit (or relative) and seconds."""

    ramp: float = 0.0
    random_walk: float = 0.0
    logarithmic: float = 0.0
    arrhenius: float = 0.0
    ramp_spread: float = 0.0
    logarithmic_spread: float = 0.0
    arrhenius_spread: float = 0.0
    onset: float = 86400.0
    temperature: float = 298.15
    reference_temperature: float = 298.15
    activation_energy: float = 1.1215236438e-19
    relative: bool = False
    cycles: float = 0.0
    cycles_spread: float = 0.0
    cycle_range: float = 100.0
    cycle_exponent: float = 2.0
    mission: str = ""
    history: Mission | None = None  # of that mission

    def __repr__(self) -> str:
        """Return the laws as they have always been written, without their defaults."""
        fields = ((field, getattr(self, field.name)) for field in dataclasses.fields(self))
        new = (f"{of.name}={value!r}" for of, value in fields if of.name not in _LATER or value != of.default)
        return f"Drift({', '.join(new)})"

    def aged(
        self,
        value: float,
        ages: Sequence[float],
        seed: int,
        run: int,
        stream: int,
        normal: Callable[[int, int, int, int], float] = normal_deviate,
    ) -> list[float]:
        """Return the value at each of the ages (seconds, ascending) in one sensor; `normal` draws the deviates."""

        def pace(law: str, sample: int) -> float:
            spread: float = getattr(self, f"{law}_spread")
            mean: float = getattr(self, law)
            return mean + spread * normal(seed, run, stream, sample) if spread else mean

        ramp, logarithmic, arrhenius = pace("ramp", 0), pace("logarithmic", 1), pace("arrhenius", 2)
        law = logarithmic_ageing.Constants(logarithmic / math.log(10.0), self.onset, 0.0, 1.0)
        energy = self.activation_energy / arrhenius_ageing.BOLTZMANN
        law_of_heat = arrhenius_ageing.Constants(0.0, energy, energy / self.reference_temperature, 1.0)
        if self.history is None:
            arrhenius *= arrhenius_ageing.acceleration_at(law_of_heat, self.temperature)
        cycled = pace("cycles", _FIRST_STEP - 1) if self.cycles or self.cycles_spread else 0.0
        steps = [ages[0], *(late - early for early, late in pairwise(ages))]
        changed, walked = [], 0.0
        for number, (age, step) in enumerate(zip(ages, steps, strict=True)):
            walked += self.random_walk * math.sqrt(step) * normal(seed, run, stream, _FIRST_STEP + number)
            if self.history is None:
                deviation = (ramp + arrhenius) * age + walked + logarithmic_ageing.deviation_at(law, age)
            else:
                worn = cycled * self.history.wear(age, self.cycle_exponent, self.cycle_range)
                heated = arrhenius * self.history.exposure(age, law_of_heat)
                deviation = ramp * age + heated + worn + walked + logarithmic_ageing.deviation_at(law, age)
            changed.append(value * (1.0 + deviation) if self.relative else value + deviation)
        return changed


def read_drift(table: object, unit: str, missions: Mapping[str, Mission] = NO_MISSIONS) -> Drift:
    """An entry of `[drift]` for a parameter of that unit; raises `Refusal`."""
    table = checked_table(table, DRIFT_KEYS, 'write { ramp = "20 ppm/year", relative = true }')
    if not any(law in table for law in LAWS):
        raise Refusal("needs a law of ageing", got=shown(dict(table)), expected=f"one or more of {', '.join(LAWS)}")
    for key, law in NEEDED_BY.items():
        if key in table and law not in table:
            raise Refusal(f"there is no {law} to go with it", key=key, hint=f"add {law}, or leave {key} out")
    mission = _mission(table, missions)
    relative = read_flag(table, "relative")
    base = "1" if relative else f"({unit})"
    units = {"ramp": f"{base}/s", "random_walk": f"{base}/sqrt(s)", "logarithmic": base, "arrhenius": f"{base}/s"}
    units["cycles"] = base
    units |= {f"{law}_spread": of for law, of in units.items()}
    signed = {key: (of, 0.0 if key.endswith(("_spread", "random_walk")) else -math.inf) for key, of in units.items()}
    kinds = signed | _NUMBERS
    numbers = {key: read_quantity(table, key, *kinds[key]) for key in table if key in kinds}
    return Drift(**numbers, relative=relative, mission=mission, history=missions.get(mission))


def _mission(table: Mapping[str, Any], missions: Mapping[str, Mission]) -> str:
    """Return the name of the mission of a table; "" where it has none."""
    name = table.get("mission", "")
    if "mission" in table and (not isinstance(name, str) or name not in missions):
        hint = did_you_mean(str(name), missions, "the missions") if missions else "add [study.missions]"
        raise Refusal("there is no such mission", hint, key="mission", got=shown(name))
    if "mission" in table and not {"arrhenius", "cycles"} & table.keys():
        raise Refusal("no law follows it", key="mission", got=shown(name), expected="arrhenius or cycles")
    if "cycles" in table and "mission" not in table:
        raise Refusal("needs a mission whose cycles it counts", key="cycles", got=shown(table["cycles"]))
    if "mission" in table and "temperature" in table:
        raise Refusal("the mission says the temperature", key="temperature", got=shown(table["temperature"]))
    return str(name)
