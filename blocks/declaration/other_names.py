"""Kinds of blocks by their names in other tools."""

import re
from collections.abc import Iterable
from difflib import SequenceMatcher

from proofmass.blocks.declaration.problem import did_you_mean, nearest

_MISSPELT = 0.72  # likeness from which on an unknown kind is taken for a misspelt one

_RECORDED = 'signals are recorded by probes: probes = ["block.output"]'
_ANSWERS: dict[str, str] = dict.fromkeys(
    ("scope", "display", "outport", "toworkspace", "probe", "sink", "plot"), _RECORDED
)
_ANSWERS |= {
    "subsystem": 'a subgraph is a block with graph = "FILE.toml" instead of a kind',
    "terminator": "outputs that nothing uses need no block: remove it",
    "ground": "give the input a Constant",
    "filter": "here that is LowPass, Butterworth or TransferFunction; `proofmass blocks --find filter` lists more",
    "noise": "here that is WhiteNoise; `proofmass blocks --find noise` lists more",
}
_PARTS = "the library has it as a part: write graph = "
_ANSWERS |= dict.fromkeys(("pll", "phaselockedloop"), f'{_PARTS}"library:phase_locked_loop.toml"')
_ANSWERS |= dict.fromkeys(("costas", "costasloop"), f'{_PARTS}"library:costas_loop.toml"')
_KINDS = {  # names in other tools -> kinds here
    # signals
    ("multiplier", "multiply"): "Product",
    ("mixer", "modulator"): "Product, or PhaseMixer of two phases",
    ("limiter", "clipper", "clamp", "limit", "saturate"): "Saturation",
    ("slew rate", "slew rate limiter"): "RateLimiter",
    ("zero-order hold", "zoh", "hold", "track and hold"): "SampleAndHold",
    ("foh",): "FirstOrderHold",
    ("memory", "register", "z^-1"): "UnitDelay",
    ("transport delay", "dead time"): "Delay, or FractionalDelay of any length",
    ("variable delay",): "FractionalDelay",
    ("scale", "torquer", "resistor"): "Gain",
    ("adder", "add", "summer", "junction", "summing junction"): "Sum",
    ("subtract", "subtractor", "error"): "Difference",
    ("divide", "divider"): "Quotient",
    ("inverter", "invert"): "Negation of a number, NotGate of a truth value",
    ("quantizer", "rounding"): "Quantiser",
    ("lookup", "table", "lookup table 1d", "interpolation"): "LookUpTable",
    ("lookup table 2d", "map"): "SurfaceTable",
    ("hysteresis", "schmitt trigger", "schmitt"): "Relay",
    ("dead band",): "DeadZone",
    ("play", "gear lash"): "Backlash",
    ("abs", "rectifier"): "Absolute",
    ("signum",): "Sign",
    ("sqrt",): "SquareRoot",
    ("exp",): "Exponential",
    ("log", "ln", "log10", "decibels"): "Logarithm",
    ("pow", "square", "exponent"): "Power",
    ("hypot", "norm"): "Magnitude",
    ("atan2", "four-quadrant arctangent"): "ArcTangent2",
    ("sin",): "SineFunction",
    ("cos",): "CosineFunction",
    ("tan",): "TangentFunction",
    ("asin",): "ArcSine",
    ("tanh", "soft limiter"): "HyperbolicTangent",
    ("max",): "Maximum",
    ("min",): "Minimum",
    ("inner product", "scalar product"): "DotProduct",
    ("mux", "vector concatenate"): "VectorJoin",
    ("demux", "selector"): "VectorElement",
    ("and", "conjunction"): "AndGate",
    ("or", "disjunction"): "OrGate",
    ("xor", "exclusive or"): "XorGate",
    ("not",): "NotGate",
    ("flip-flop", "d flip-flop"): "DataFlipFlop",
    ("sr latch", "rs flip-flop"): "SetResetLatch",
    ("rising edge", "detect rise", "one shot"): "EdgeDetector",
    ("stateflow", "sequencer"): "StateMachine",
    # filters and control
    ("integrate", "accumulator"): "Integrator, or DiscreteIntegrator at a rate",
    ("derivative", "derivate"): "Differentiator",
    ("first-order lag", "rc filter", "pt1"): "LowPass",
    ("low-pass filter",): "LowPass, or Butterworth at a rate",
    ("transfer fcn", "laplace"): "TransferFunction",
    ("discrete transfer fcn", "discrete filter"): "DiscreteTransferFunction",
    ("lti",): "StateSpace, TransferFunction or HeldStateSpace",
    ("lead compensator", "lag compensator", "lead", "lag"): "LeadLag",
    ("phase shifter",): "AllPass",
    ("band-stop of one frequency", "trap filter"): "Notch",
    ("boxcar", "running mean", "sliding average"): "MovingAverage",
    ("downsample", "downsampler"): "Decimator, or DecimatingFilter",
    ("fir", "fir filter"): "FiniteImpulseResponse",
    ("iir", "biquad", "sos", "biquad filter"): "SecondOrderSection",
    ("cic",): "CascadedIntegratorComb",
    ("high-pass", "high-pass filter"): "Butterworth with high_pass = true",
    (
        "bandpass",
        "bandpass filter",
        "bandstop",
        "bandstop filter",
        "band reject",
    ): "ButterworthBand, EllipticBand or BesselBand",
    ("cauer", "cauer filter", "ellip", "elliptic filter"): "Elliptic or EllipticBand",
    ("pid controller", "pi", "pd", "controller"): "PID",
    # sources
    ("sine wave", "sinus", "cosine", "signal generator"): "Sine",
    ("square wave", "pulse generator", "clock"): "Pulse",
    ("heaviside",): "Step",
    ("sweep", "swept sine"): "Chirp",
    ("staircase",): "PiecewiseConstant",
    ("repeating table", "arbitrary waveform"): "RepeatingSequence",
    ("lfsr", "prbs", "pn", "mls"): "ShiftRegister",
    ("inport", "from workspace", "from file", "recording", "playback"): "RecordedSignal",
    # noise and drift
    ("random number", "gaussian noise", "band-limited white noise", "johnson noise", "shot noise"): "WhiteNoise",
    ("pink noise", "one over f", "1/f noise", "bias instability"): "FlickerNoise",
    ("brown noise", "wiener process"): "RandomWalk",
    ("ornstein-uhlenbeck", "first-order markov"): "GaussMarkov",
    ("thermomechanical noise",): "BrownianForce",
    ("imu errors", "data sheet"): "InertialErrors",
    # electronics and converters
    ("amplifier", "amp"): "Gain, or InstrumentationAmplifier",
    ("opamp", "operational amplifier", "in-amp"): "InstrumentationAmplifier",
    ("charge-sensitive amplifier", "csa"): "ChargeAmplifier",
    ("capacitive pickoff", "pickoff"): "DisplacementReadout",
    ("transconductance", "howland source"): "VoltageToCurrent",
    ("thermometer", "thermistor"): "TemperatureSensor",
    ("adc", "analog-to-digital converter", "sampler"): "AnalogToDigital",
    ("dac", "digital-to-analog converter"): "DigitalToAnalog",
    ("delta-sigma", "delta-sigma modulator"): "SigmaDeltaModulator",
    ("cds",): "CorrelatedDoubleSampling",
    ("chopper",): "ChopperModulator",
    ("inl",): "IntegralNonlinearity, or MeasuredNonlinearity from a table",
    ("tdc", "time-to-digital converter", "time interval counter"): "TimeToDigital",
    ("sar", "sar adc"): "SuccessiveApproximation",
    ("pipeline adc",): "PipelineAnalogToDigital",
    ("kt/c noise", "aperture jitter"): "SamplingNoise",
    ("pwm",): "PulseWidthModulator",
    # oscillators
    ("nco", "dds"): "NumericallyControlledOscillator",
    ("vco",): "VoltageControlledOscillator",
    ("lock-in", "lock-in amplifier", "iq demodulator", "demodulator"): "InPhaseQuadratureDemodulator",
    ("agc",): "AutomaticGainControl",
    ("pfd",): "PhaseFrequencyDetector",
    ("envelope detector",): "AmplitudeDetector",
    # mechanics, magnetics, optics
    ("reduced-order model", "modal model", "finite element"): "ModalReducedOrderModel",
    ("electromagnet", "magnetic bearing", "levitation"): "MagneticLevitation",
    ("thermal expansion",): "ThermoelasticExpansion",
    ("piezo", "pzt"): "PiezoelectricActuator, or PiezoelectricSensor",
    ("coupler", "beam splitter", "directional coupler"): "FibreCoupler",
    ("geophone", "seismometer"): "MassSpringDamper",
    ("spring mass", "resonator", "proof mass", "second-order system"): "MassSpringDamper",
    ("mass", "spring", "damper", "dashpot"): "MassSpringDamper: mass, damper and spring together",
    ("cubic spring",): "DuffingSpring",
    ("hard stop", "end stop"): "MassBetweenStops",
    ("parallel-plate actuator",): "GapClosingActuator",
    ("negative spring",): "ElectrostaticSoftening",
    ("misalignment matrix",): "MisalignedTriad",
    ("ring gyroscope", "hemispherical resonator"): "VibratingRing",
    ("park transform", "inverse park transform", "coordinate rotation"): "VectorRotation",
    ("unwrap", "phase unwrap"): "PhaseUnwrapper",
    ("vibrating beam", "double-ended tuning fork"): "ResonantBeam",
    ("hall sensor",): "HallElement",
    ("amr", "gmr", "tmr", "magnetoresistor"): "MagnetoresistiveBridge",
    ("photodiode",): "Photodetector",
    ("fibre coil",): "SagnacCoil",
    ("phase detector",): "PhaseMixer, XorPhaseDetector or PhaseFrequencyDetector",
    # statistics
    ("adev",): "AllanDeviation",
    ("quantile",): "RunningPercentile",
    ("goertzel",): "ToneMeter",
}


def _squashed(word: str) -> str:
    """A name without the signs between its words, so that zero-order hold is ZeroOrderHold."""
    return re.sub(r"[_ -]", "", word.lower())


_ANSWERS |= {_squashed(word): f"here that is {kinds}" for words, kinds in _KINDS.items() for word in words}


def other_names(kind: str) -> list[str]:
    """Return the names that a kind has in other tools.

    >>> other_names("Difference")
    ['subtract', 'subtractor', 'error']
    """
    return [word for words, kinds in _KINDS.items() if re.search(rf"\b{kind}\b", kinds) for word in words]


def kind_hint(word: str, kinds: Iterable[str], own: bool) -> str:
    """Return a kind to write instead of an unknown one; without `own` it says how to bring them.

    >>> kind_hint("Limiter", ["Saturation"], own=True)
    'here that is Saturation.'
    """
    answer = _ANSWERS.get(_squashed(word))
    if answer:
        return f"{answer}."
    names = list(kinds)
    hint, near = did_you_mean(word, names, "the kinds"), nearest(word, names)
    misspelt = near[:1].lower() == word[:1].lower() and SequenceMatcher(None, word, near).ratio() > _MISSPELT
    return hint if own or misspelt else f"{hint} Blocks of your own need --blocks FILE."
