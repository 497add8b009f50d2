"""How a parameter drifts along the epochs of a study: laws of ageing, evaluated at an age instead of simulated.

d(t) = ramp t + w(t) + logarithmic log10(1 + t / onset) + arrhenius t exp(E / k (1 / T0 - 1 / T))

w is a random walk with standard deviation `random_walk` sqrt(t). The paces of one sensor differ from those of another
by normal deviates of the stated spread. The laws are those of the blocks DriftRamp, RandomWalk, LogarithmicAgeing and
ArrheniusAgeing.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from proofmass.blocks.arithmetic.counter_random import normal_deviate
from proofmass.blocks.declaration.problem import Refusal, shown
from proofmass.blocks.noise_and_drift import arrhenius_ageing, logarithmic_ageing
from proofmass.graphs.studies.table_entries import checked_table, read_flag, read_quantity

LAWS = ("ramp", "random_walk", "logarithmic", "arrhenius")
_SPREAD = {
    f"{law}_spread": f"Standard deviation of {law} from sensor to sensor." for law in LAWS if law != "random_walk"
}
DRIFT_KEYS = {
    "ramp": 'Change per time: "20 ppm/year".',
    "random_walk": 'Standard deviation after a time: "5 ppm/sqrt(year)".',
    "logarithmic": "Change per factor of ten in age, from the onset on.",
    "arrhenius": 'Change per time at the reference temperature, "10 ppm/year", sped up by the temperature.',
    **_SPREAD,
    "onset": "Age at which the logarithm sets in, 1 d when nothing is said.",
    "temperature": "Temperature at which the sensor is kept, 298.15 K when nothing is said.",
    "reference_temperature": "Temperature of the stated pace, 298.15 K when nothing is said.",
    "activation_energy": "0.7 eV when nothing is said.",
    "relative": "true: changes are relative to the value of the graph.",
}
NEEDED_BY = {
    "onset": "logarithmic",
    "temperature": "arrhenius",
    "reference_temperature": "arrhenius",
    "activation_energy": "arrhenius",
    **{key: key.removesuffix("_spread") for key in _SPREAD},
}
_DEFAULTS = {"onset": 86400.0, "temperature": 298.15, "reference_temperature": 298.15, "activation_energy": 1.1215e-19}
_UNITS = {"onset": "s", "temperature": "K", "reference_temperature": "K", "activation_energy": "J"}
_LEAST = {"onset": 1e-3, "temperature": 1.0, "reference_temperature": 100.0, "activation_energy": 0.0}


@dataclass(frozen=True)
class Drift:
    """The laws by which one parameter ages, in its unit (or relative) and seconds."""

    ramp: float = 0.0
    random_walk: float = 0.0
    logarithmic: float = 0.0
    arrhenius: float = 0.0
    ramp_spread: float = 0.0
    logarithmic_spread: float = 0.0
    arrhenius_spread: float = 0.0
    onset: float = _DEFAULTS["onset"]
    temperature: float = _DEFAULTS["temperature"]
    reference_temperature: float = _DEFAULTS["reference_temperature"]
    activation_energy: float = _DEFAULTS["activation_energy"]
    relative: bool = False

    def aged(
        self,
        value: float,
        ages: Sequence[float],
        seed: int,
        run: int,
        stream: int,
        normal: Callable[[int, int, int, int], float] = normal_deviate,
    ) -> list[float]:
        """What a value becomes at each of the ages (seconds, ascending) in one sensor; `normal` gives the deviates."""

        def pace(law: str, sample: int) -> float:
            spread: float = getattr(self, f"{law}_spread")
            mean: float = getattr(self, law)
            return mean + spread * normal(seed, run, stream, sample) if spread else mean

        ramp, logarithmic, arrhenius = pace("ramp", 0), pace("logarithmic", 1), pace("arrhenius", 2)
        law = logarithmic_ageing.Constants(logarithmic / math.log(10.0), self.onset, 0.0, 1.0)
        arrhenius *= self._acceleration()
        steps = [ages[0], *(late - early for early, late in pairwise(ages))]
        changed, walked = [], 0.0
        for number, (age, step) in enumerate(zip(ages, steps, strict=True)):
            walked += self.random_walk * math.sqrt(step) * normal(seed, run, stream, len(LAWS) + number)
            deviation = (ramp + arrhenius) * age + walked + logarithmic_ageing.deviation_at(law, age)
            changed.append(value * (1.0 + deviation) if self.relative else value + deviation)
        return changed

    def _acceleration(self) -> float:
        energy = self.activation_energy / arrhenius_ageing.BOLTZMANN
        law = arrhenius_ageing.Constants(0.0, energy, energy / self.reference_temperature, 1.0)
        return arrhenius_ageing.acceleration_at(law, self.temperature)


def read_drift(table: object, unit: str) -> Drift:
    """An entry of `[drift]` for a parameter of that unit; raises `Refusal`."""
    table = checked_table(table, DRIFT_KEYS, 'write { ramp = "20 ppm/year", relative = true }')
    if not any(law in table for law in LAWS):
        raise Refusal("needs a law of ageing", got=shown(dict(table)), expected=f"one or more of {', '.join(LAWS)}")
    for key, law in NEEDED_BY.items():
        if key in table and law not in table:
            raise Refusal(f"there is no {law} to go with it", key=key, hint=f"add {law}, or leave {key} out")
    relative = read_flag(table, "relative")
    base = "1" if relative else f"({unit})"
    units = {"ramp": f"{base}/s", "random_walk": f"{base}/sqrt(s)", "logarithmic": base, "arrhenius": f"{base}/s"}
    units |= {f"{law}_spread": of for law, of in units.items()} | _UNITS
    least = {key: _LEAST.get(key, 0.0 if key.endswith(("_spread", "random_walk")) else -math.inf) for key in units}
    numbers = {key: read_quantity(table, key, units[key], least[key]) for key in table if key != "relative"}
    return Drift(**numbers, relative=relative)
