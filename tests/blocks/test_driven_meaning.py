"""Which parameters a wire may drive: those whose momentary value says nothing about the time before."""

import math

import pytest

from proofmass.blocks import Chirp, PeriodicDrift, Sine
from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.checks.check import checked
from proofmass.graphs.model.build import Graph

# Looked at one by one. Of a block with a memory each one acts on what is added to the memory, or scales what comes
# out; what it was before stays.
DRIVEN = {
    "AllPass": {"frequency", "quality"},
    "AmplitudeDetector": {"corner_frequency"},
    "AnalogSwitch": {"leakage"},
    "AnalogToDigital": {"reference", "offset_error", "gain_error"},
    "ArcSine": {"reference"},
    "ArrheniusAgeing": {"pace", "activation_energy", "reference_temperature", "nominal"},
    "AutomaticGainControl": {"setpoint", "time_constant", "lowest", "highest"},
    "Backlash": {"width"},
    "Bessel": {"corner_frequency"},
    "BrownianForce": {"damping", "temperature"},
    "Butterworth": {"corner_frequency"},
    "CapacitanceBridge": {"first_reference", "second_reference", "stray"},
    "ChargeAmplifier": {"feedback_resistance"},
    "ChebyshevType1": {"corner_frequency", "ripple"},
    "ChebyshevType1Band": {"ripple"},
    "ChebyshevType2": {"corner_frequency", "attenuation"},
    "ChebyshevType2Band": {"attenuation"},
    "Chirp": {"amplitude", "phase", "offset"},
    "CombDrive": {"bias", "capacitance_gradient"},
    "Comparator": {"threshold", "hysteresis"},
    "CompensationRegister": {"initial", "limit"},
    "ComplementaryFilter": {"time_constant"},
    "Constant": {"value"},
    "ConvergenceMonitor": {"tolerance"},
    "CoriolisForce": {"mass"},
    "CosineFunction": {"amplitude"},
    "CrossAxisMass": {
        "mass",
        "first_sensitivity",
        "second_sensitivity",
        "second_order",
        "first_coupling",
        "second_coupling",
    },
    "DampingController": {"gain", "lowest"},
    "Differentiator": {"gain", "corner_frequency"},
    "DelayedComparator": {"threshold", "hysteresis"},
    "DifferentialComb": {"height", "gap", "thickness", "overlap", "fringe"},
    "DigitalToAnalog": {"reference"},
    "DiscreteIntegrator": {"gain"},
    "DiscreteMassSpringDamper": {"mass", "damping", "stiffness", "acceleration_at_end", "velocity_at_end"},
    "DiscreteStateSpace": {"direct"},
    "DisplacementReadout": {"gain", "offset"},
    "DoubleExponentialModel": {"a1", "b1", "a2", "b2"},
    "DriftOffset": {"offset", "nominal"},
    "DriftRamp": {"start_time", "nominal"},
    "DuffingSpring": {"linear", "quadratic", "cubic"},
    "ElectrostaticSoftening": {"capacitance", "gap"},
    "Elliptic": {"corner_frequency"},
    "Exponential": {"scale", "reference"},
    "FabryPerotCavity": {
        "length",
        "front_reflectivity",
        "back_reflectivity",
        "modulation_frequency",
        "modulation_depth",
    },
    "FibreCoupler": {"coupling", "transmission", "coherence"},
    "FitSelector": {"residual_limit"},
    "FlexurePendulum": {"inertia", "damping", "stiffness"},
    "FlickerNoise": {"level", "nominal"},
    "Fluxgate": {"saturation", "knee", "demagnetisation", "turns", "area"},
    "FrequencyCounter": {"gate"},
    "Gain": {"gain"},
    "GapCapacitorPair": {"capacitance", "gap", "lever"},
    "GapClosingActuator": {"bias", "capacitance", "gap"},
    "GaussMarkov": {"standard_deviation", "correlation_time", "nominal"},
    "GaussNewtonController": {"largest_step"},
    "HBridge": {"supply", "on_resistance", "dead_time", "forward_voltage"},
    "HallElement": {"sensitivity", "offset"},
    "HyperbolicTangent": {"limit"},
    "InPhaseQuadratureDemodulator": {"corner_frequency"},
    "InertialErrors": {
        "scale",
        "scale_temperature",
        "asymmetry",
        "second_order",
        "bias",
        "bias_temperature",
        "acceleration_sensitivity",
    },
    "InstrumentationAmplifier": {"feedback_resistance", "gain_resistance"},
    "IntegralNonlinearity": {"reference", "bow", "s_shape"},
    "Integrator": {"gain"},
    "Interferometer": {"peak", "visibility"},
    "LeadLag": {"zero_frequency", "pole_frequency", "gain"},
    "LeastSquaresController": {"largest_step"},
    "LogarithmicAgeing": {"nominal"},
    "Logarithm": {"base", "scale", "reference", "smallest"},
    "LoopFilter": {"natural_frequency", "damping", "detector_gain", "oscillator_gain"},
    "LowPass": {"corner_frequency", "gain"},
    "MagneticLevitation": {"force_constant", "gap", "bias"},
    "MagnetoresistiveAngleBridge": {"ratio", "direction", "reference_field", "imbalance"},
    "MagnetoresistiveBridge": {"ratio", "saturation", "imbalance"},
    "MashModulator": {"leakage", "reference"},
    "MassBetweenStops": {"mass", "damping", "stiffness", "restitution", "sticking_speed"},
    "MassSpringDamper": {"mass", "damping", "stiffness"},
    "MeasuredNonlinearity": {"reference"},
    "MisalignedTriad": {"scale_x", "scale_y", "scale_z", "xy", "xz", "yx", "yz", "zx", "zy"},
    "ModeCoupledGyroscope": {
        "mass",
        "drive_frequency",
        "drive_quality",
        "sense_frequency",
        "sense_quality",
        "angular_gain",
        "rotation",
        "quadrature_rate",
        "damping_rate",
    },
    "Notch": {"frequency", "quality"},
    "NumericallyControlledOscillator": {"frequency", "gain", "amplitude", "lead"},
    "OneBitActuator": {"level"},
    "PID": {"proportional", "integral", "derivative_gain", "derivative_pole"},
    "PeriodicDrift": {"amplitude", "phase", "nominal"},
    "PhaseFrequencyDetector": {"level"},
    "PhaseMixer": {"first_amplitude", "second_amplitude"},
    "PhaseModulator": {"half_wave_voltage"},
    "Photodetector": {"responsivity", "dark_current", "intensity_noise"},
    "PiezoelectricActuator": {"coupling", "stiffness", "capacitance"},
    "PiezoelectricSensor": {"coupling", "capacitance", "resistance"},
    "PlateAttach": {"stop_angle"},
    "PolynomialModel": {"c0", "c1", "c2", "c3", "c4", "c5", "c6"},
    "Power": {"exponent", "reference", "scale"},
    "Pulse": {"amplitude", "offset", "duty", "delay"},
    "PulseWidthModulator": {"frequency", "low", "high"},
    "Quotient": {"smallest"},
    "Ramp": {"offset", "start_time"},
    "RandomWalk": {"coefficient", "nominal"},
    "RateLimiter": {"rising", "falling"},
    "Relay": {"off", "on"},
    "ResonantBeam": {"mass", "frequency", "quality", "axial_force", "critical_force"},
    "SagnacCoil": {"length", "diameter", "wavelength"},
    "SamplingNoise": {"capacitance", "temperature", "jitter"},
    "SecondOrderSection": {"b0", "b1", "b2", "a1", "a2"},
    "SelfTestVerdict": {"residual_limit"},
    "SettlingTime": {"target", "within", "delay"},
    "SigmaDeltaModulator": {"resonance", "reference"},
    "Sine": {"amplitude", "phase", "offset"},
    "SineFunction": {"amplitude"},
    "SqueezeFilmDamping": {"gap", "viscosity"},
    "Step": {"amplitude", "start_time", "duration", "offset"},
    "StiffnessController": {"initial", "gain"},
    "SuccessiveApproximation": {"reference", "noise"},
    "SweepNumber": {"first", "increment", "working"},
    "TangentFunction": {"scale"},
    "TemperatureDoubleExponential": {"a1", "b1", "a2", "b2", "nominal"},
    "TemperaturePolynomial": {"tc1", "tc2", "reference_temperature", "nominal"},
    "TemperatureSensor": {"reference_voltage", "slope", "reference_temperature"},
    "ThermoelasticExpansion": {
        "length",
        "expansion",
        "quadratic",
        "frame_expansion",
        "reference_temperature",
        "stiffness",
    },
    "TimeToDigital": {"resolution"},
    "ToleranceCheck": {"stiffness_nominal", "stiffness_tolerance", "damping_nominal", "damping_tolerance"},
    "TwoPositionComparison": {"gravity"},
    "UnipolarDigitalToAnalog": {"reference"},
    "VibratingRing": {
        "mass",
        "frequency",
        "time_constant",
        "angular_gain",
        "frequency_split",
        "split_angle",
        "damping_split",
        "damping_angle",
        "rotation",
    },
    "VoltageControlledOscillator": {"frequency", "gain", "amplitude"},
    "VoltageToCurrent": {"resistance"},
    "WeightedDigitalToAnalog": {"reference"},
    "WhiteNoise": {"density"},
    "WrappingIntegrator": {"gain"},
    "XorPhaseDetector": {"level"},
    "ZeroBiasVoltage": {"a1", "b1", "a2", "b2", "offset", "hysteresis", "width"},
}
REFUSED = {
    "ChargeAmplifier": {"feedback_capacitance": "Gain"},
    "Chirp": dict.fromkeys(("start_frequency", "stop_frequency", "sweep_time"), "NumericallyControlledOscillator"),
    "DensityMeter": {"frequency": "DensityMeter"},
    "DriftRamp": {"slope": "DiscreteIntegrator"},
    "LogarithmicAgeing": dict.fromkeys(("rate_per_decade", "onset", "start_age"), "ArrheniusAgeing"),
    "MeasurementSlots": dict.fromkeys(("settling", "averaging"), "MeasurementSlots"),
    "PeriodicDrift": {"cycle_time": "NumericallyControlledOscillator"},
    "Pulse": {"repetition": "NumericallyControlledOscillator"},
    "Ramp": {"slope": "DiscreteIntegrator"},
    "RunningPercentile": {"percent": "RunningPercentile"},
    "Sine": {"frequency": "NumericallyControlledOscillator"},
    "TemperatureCycle": dict.fromkeys(("pace", "soak_time"), "DiscreteIntegrator"),
    "ToneMeter": dict.fromkeys(("frequency", "delay"), "ToneMeter"),
}
KINDS = all_blocks()


@pytest.mark.parametrize("name", KINDS)
def test_a_wire_may_drive_what_the_table_says(name: str) -> None:
    kind = KINDS[name]
    assert {p for p in kind.parameters if kind.drivable(p)} == DRIVEN.get(name, set())
    refused = {p for p in kind.parameters if kind.taken_in_the_loop(p)} - DRIVEN.get(name, set())
    assert refused == REFUSED.get(name, {}).keys()


def driven(name: str, parameter: str) -> Graph:
    block = KINDS[name]()
    unit = unit_of(block, type(block).parameters[parameter])
    blocks = {"word": KINDS["Constant"](unit=unit), "driven": block}
    return Graph(name="driven", rate=1000, blocks=blocks, wires=[f"word.output -> driven.{parameter}"])


@pytest.mark.defect("S6", before="check is silent: sin(2 pi f(t) t)", after="refused, with the block to take instead")
@pytest.mark.parametrize(("name", "parameter"), [(name, p) for name, known in REFUSED.items() for p in known])
def test_the_others_are_refused_with_the_block_to_take_instead(name: str, parameter: str) -> None:
    with pytest.raises(ModelError) as caught:
        checked(driven(name, parameter))
    problem = next(p for p in caught.value.problems if p.path[0] == "wires")
    assert problem.message == f"driven.{parameter} cannot be driven"
    assert REFUSED[name][parameter] in problem.hint
    assert REFUSED[name][parameter] in KINDS


def test_sine_is_told_in_these_words() -> None:
    with pytest.raises(ModelError, match="take a NumericallyControlledOscillator") as caught:
        checked(driven("Sine", "frequency"))
    assert "sin(2 pi f t) does not oscillate at a moving frequency f" in str(caught.value)


def slopes(block: Block, parameter: str, times: list[float]) -> list[float]:
    """How much the outputs at some times depend on a parameter, by differences."""
    value = getattr(block, parameter)
    step = 1e-7 * (abs(value) or 1.0)
    values = {name: getattr(block, name) for name in type(block).parameters}
    rows = []
    for moved in (block, type(block)(**(values | {parameter: value + step}))):
        made = type(block).functions.get("constants")
        known = made.function(moved, 1e-3) if made else moved
        functions = [b.function for b in type(block).output_functions.values() if b.arguments == ("time",)]
        rows.append([f(known, t) for f in functions for t in times])
    return [abs(b - a) / step for a, b in zip(*rows, strict=True)]


OF_TIME = [
    k for k in KINDS.values() if k.output_functions and any("time" in b.arguments for b in k.output_functions.values())
]


@pytest.mark.parametrize("kind", [k for k in OF_TIME if k.state_class() is None], ids=lambda kind: kind.__name__)
def test_what_a_driven_parameter_does_to_a_source_does_not_grow_with_the_time_that_has_passed(
    kind: type[Block],
) -> None:
    quick = {Chirp: {"sweep_time": 1e9}, PeriodicDrift: {"cycle_time": 1.0}}
    block = kind(**quick.get(kind, {}))
    for parameter in DRIVEN.get(kind.__name__, ()):
        early = max(slopes(block, parameter, [0.1 + 0.0137 * n for n in range(100)]))
        late = max(slopes(block, parameter, [5000.1 + 0.0137 * n for n in range(100)]))
        assert late <= 100.0 * early + 1e-9, parameter


def test_what_is_refused_of_the_sine_does_grow() -> None:
    assert max(slopes(Sine(), "frequency", [5000.013])) > 100.0 * max(slopes(Sine(), "frequency", [0.1, 0.2137]))
    assert math.isfinite(max(slopes(Sine(), "amplitude", [5000.013])))
