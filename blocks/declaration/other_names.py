"""Kinds of blocks by their names in other tools."""

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
}
_KINDS = {
    ("mixer", "multiplier", "multiply", "modulator"): "Product, or PhaseMixer of two phases",
    ("limiter", "clipper", "clamp", "limit", "saturate"): "Saturation",
    ("slewrate", "slewratelimiter"): "RateLimiter",
    ("integrate", "accumulator"): "Integrator, or DiscreteIntegrator at a rate",
    ("derivative", "derivate"): "Differentiator",
    ("zeroorderhold", "zoh", "hold", "trackandhold"): "SampleAndHold",
    ("memory", "register", "transportdelay"): "UnitDelay, Delay or FractionalDelay",
    ("amplifier", "amp", "scale", "torquer", "resistor"): "Gain, or InstrumentationAmplifier",
    ("adder", "add", "summer", "junction", "summingjunction"): "Sum",
    ("subtract", "subtractor", "error"): "Difference",
    ("divide", "divider"): "Quotient",
    ("inverter", "invert"): "Negation of a number, NotGate of a truth value",
    ("noise", "randomnumber", "gaussiannoise", "bandlimitedwhitenoise"): "WhiteNoise",
    ("pinknoise", "oneoverf", "brownnoise"): "FlickerNoise or RandomWalk",
    ("adc", "analogtodigitalconverter", "sampler"): "AnalogToDigital",
    ("dac", "digitaltoanalogconverter"): "DigitalToAnalog",
    ("quantizer", "rounding"): "Quantiser",
    ("pidcontroller", "pi", "pd", "controller"): "PID",
    ("lookup", "table", "lookuptable1d", "interpolation"): "LookUpTable",
    ("lfsr", "prbs", "pn", "mls"): "ShiftRegister",
    ("hysteresis", "schmitttrigger", "schmitt"): "Relay",
    ("fir", "firfilter"): "FiniteImpulseResponse",
    ("iir", "biquad", "sos", "biquadfilter"): "SecondOrderSection",
    ("cic",): "CascadedIntegratorComb",
    (
        "bandpass",
        "bandpassfilter",
        "bandstop",
        "bandstopfilter",
        "bandreject",
    ): "ButterworthBand, EllipticBand or BesselBand",
    ("cauer", "cauerfilter", "ellip", "ellipticfilter"): "Elliptic or EllipticBand",
    ("highpass", "highpassfilter"): "Butterworth with high_pass = true",
    ("nco", "dds"): "NumericallyControlledOscillator",
    ("vco",): "VoltageControlledOscillator",
    ("lockin", "lockinamplifier", "iqdemodulator", "demodulator"): "InPhaseQuadratureDemodulator",
    ("agc",): "AutomaticGainControl",
    ("inport", "fromworkspace", "fromfile", "recording", "playback"): "RecordedSignal",
    ("springmass", "springmassdamper", "resonator", "proofmass"): "MassSpringDamper",
    ("sinewave", "sinus", "cosine", "signalgenerator"): "Sine",
    ("squarewave", "pulsegenerator", "clock"): "Pulse",
    ("pwm",): "PulseWidthModulator",
    ("abs",): "Absolute",
    ("mux", "vectorconcatenate"): "VectorJoin",
    ("demux", "selector"): "VectorElement",
    ("filter",): "LowPass, Butterworth or TransferFunction; `proofmass blocks --find filter` lists more",
    ("mass", "spring", "damper", "dashpot"): "MassSpringDamper: mass, damper and spring together",
    ("opamp", "operationalamplifier"): "InstrumentationAmplifier",
    ("sqrt",): "SquareRoot",
    ("exp",): "Exponential",
    ("log", "ln", "log10", "decibel"): "Logarithm",
    ("tdc", "timetodigitalconverter", "timeintervalcounter"): "TimeToDigital",
    ("sar", "saradc"): "SuccessiveApproximation",
    ("pipelineadc",): "PipelineAnalogToDigital",
    ("rom", "modalmodel", "femodel", "finiteelement"): "ModalReducedOrderModel",
    ("electromagnet", "magneticbearing", "levitation"): "MagneticLevitation",
    ("coupler", "beamsplitter", "directionalcoupler"): "FibreCoupler",
    ("piezo", "pzt"): "PiezoelectricActuator or PiezoelectricSensor",
}
_ANSWERS |= {word: f"here that is {kinds}" for words, kinds in _KINDS.items() for word in words}


def kind_hint(word: str, kinds: Iterable[str], own: bool) -> str:
    """Return a kind to write instead of an unknown one; without `own` blocks it says how to bring them.

    >>> kind_hint("Limiter", ["Saturation"], own=True)
    'here that is Saturation.'
    """
    answer = _ANSWERS.get(word.lower().replace("_", "").replace(" ", "").replace("-", ""))
    if answer:
        return f"{answer}."
    names = list(kinds)
    hint, near = did_you_mean(word, names, "the kinds"), nearest(word, names)
    misspelt = near[:1].lower() == word[:1].lower() and SequenceMatcher(None, word, near).ratio() > _MISSPELT
    return hint if own or misspelt else f"{hint} Blocks of your own need --blocks FILE."
