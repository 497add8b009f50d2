"""The claims of Sarraf et al. 2012, in the order of the paper."""

from functools import partial

from docs.papers import pn_findings as found
from docs.papers.claim import Claim

LOOP, GYRO, CAPACITANCES = "self_calibration_accelerometer", "self_calibration_gyroscope", "gyroscope_capacitances"
FIXED, GYRO_FIXED = "self_calibration_fixed", "self_calibration_gyroscope_fixed"
LABORATORY = "a property of instruments or of a fabrication, not of the method"
FLOW = "theirs is a block set of 2012 with operand registers, whose words are not all said; slices of ours are a bound"

BEGINNING = (
    Claim("pn-stiffness-a", "abstract, 3.3, Fig. 10", "stiffness of the accelerometer, from 49.56 N/m", "51.48 N/m",
          "holds", "12 bits and 5 mV of noise are assumed", LOOP, partial(found.identified, "accelerometer", 0)),
    Claim("pn-damping-a", "abstract, 3.3, Fig. 10", "damping of the accelerometer, from 3.4e-3 kg/s", "4.57e-3 kg/s",
          "holds", "", LOOP, partial(found.identified, "accelerometer", 1)),
    Claim("pn-stiffness-g", "abstract, 3.3, Fig. 10", "stiffness of the gyroscope, from 132 N/m", "137.7 N/m",
          "holds", "at 8.75 kHz; see pn-rate-g", GYRO, partial(found.identified, "gyroscope", 0)),
    Claim("pn-damping-g", "abstract, 3.3, Fig. 10", "damping of the gyroscope, from 5.57e-5 kg/s", "7.12e-5 kg/s",
          "holds", "", GYRO, partial(found.identified, "gyroscope", 1)),
    Claim("pn-dumas", "1", "an earlier work rejects noise by 20 dB in 2.55 s", "20 dB, 2.55 s", "open",
          "it is another paper's sensor, which is not described here"),
    Claim("pn-small", "1, 5", "small test actuation keeps the device linear", "in words", "holds",
          "gaps of 2 um are assumed", "capacitive_readout", partial(found.carrier, "20")),
    Claim("pn-correlation", "2.1, eq. 1, 2", "the cross-correlation is the impulse response", "in words", "holds",
          "the rest is what the gyroscope still rings beyond the 16 cells", LOOP, found.correlated),
    Claim("pn-sequence", "2.1, eq. 3", "autocorrelation of the sequence; it begins with ten ones", "N and -1; 10",
          "holds", "", "pn_self_test_minimal", found.autocorrelation),
    Claim("pn-coefficients", "2.1", "the first 10 to 15 coefficients are enough", "10 to 15", "differs",
          "true of the accelerometer, not of a resonator at this rate", LOOP, found.first_coefficients),
    Claim("pn-twice", "2.1", "the chip rate is twice the 3-dB frequency", "2", "fails",
          "8.5 kHz is not near twice any corner of the gyroscope, but beside its resonance", LOOP, found.chip_rate),
    Claim("pn-terms", "2.1", "p + q + 1 terms of the response determine p poles and q zeros", "3", "open",
          "a theorem of its reference, without noise; the graphs take 1 and 15"),
    Claim("pn-static", "2.1, eq. 4, 5", "a constant force shows the stiffness alone", "in words", "holds", "",
          "block MassSpringDamper", found.static),
    Claim("pn-architecture", "2.1, Fig. 2", "generator, model, cells, two controllers", "a drawing", "holds",
          "gains of the controllers are assumed", LOOP, partial(found.periods, "accelerometer")),
    Claim("pn-sensitivity", "2.1, Fig. 3", "only the first samples are sensitive", "in words", "differs",
          "true of the accelerometer, not of the gyroscope", "self_calibration_online", found.sensitivities),
    Claim("pn-gain", "2.1", "scaling constant A", "7,000", "differs",
          "read as V/ms^2; in SI units it would be 714 g", LOOP, found.static_volts),
    Claim("pn-ten", "2.1 ii", "the response is static within the first 10 clocks", "10 clocks", "differs",
          "the gyroscope's mode rings longer; the loop compares model and device, so it works all the same", LOOP,
          found.ten_clocks),
    Claim("pn-iterations", "2.1 vii, Fig. 10", "it repeats until the error is below a threshold", "not said", "open",
          "neither threshold nor number of periods is given", GYRO,
          partial(found.periods, "gyroscope")),
    Claim("pn-slower", "3.3, Fig. 10", "damping takes more clocks than stiffness", "in words", "holds",
          "in the gyroscope too", LOOP, partial(found.periods, "accelerometer")),
    Claim("pn-figure-6", "3.1, Fig. 6", "registers match floating point: 1 g, and 1 g at 90 Hz", '"match well"',
          "holds", "", "fixed_against_floating", found.registers_against_floating),
    Claim("pn-words", "3.1", "(32, 30) for small and (24, 6) for large numbers", "formats", "differs",
          "the first number is all bits, not the real part; the gyroscope's c/m needs (24, 18)",
          "fixed_against_floating", found.registers_against_floating),
    Claim("pn-controllers", "3.4", "(16, 12) for controllers and cells", "formats", "holds",
          "coefficients of the gyroscope's response are (20, 16)", FIXED, found.controllers_in_registers, slow=True),
    Claim("pn-carrier", "3.2", "carrier of 100 kHz; the output is proportional to displacement", "100 kHz", "holds",
          "by the 3/4 (x/d)^2 of the pair", "capacitive_readout", partial(found.carrier, "200")),
    Claim("pn-instruments", "3.2, 3.3", "1.2 kS/s to 1 MS/s, 25 um of silicon, motion of 2 nm", "1 MS/s, 25 um, 2 nm",
          "open", LABORATORY),
    Claim("pn-rate-a", "3.2", "4.8 kHz and 20 V for the accelerometer", "4.8 kHz", "holds", "read as the chip rate",
          LOOP, partial(found.periods, "accelerometer")),
    Claim("pn-rate-g", "3.2", "8.5 kHz and 15 V for the gyroscope", "8.5 kHz", "fails",
          "there another pair of parameters answers alike in the two numbers that the controllers see", GYRO,
          found.at_8500),
)  # fmt: skip
DEVICES = (
    Claim("pn-table-1", "3.3, Table 1", "the accelerometer: mass, stiffness, damping", "50.43, 49.5627, 0.0034",
          "differs", "these numbers are an overdamped device, which has no resonance to measure", LOOP,
          found.resonance),
    Claim("pn-half-power-g", "3.3, Fig. 4",
          "stiffness and damping by the half-power method, the gyroscope's sense mode",
          "in words", "holds", "the peak lies 1 / 4 Q^2 below the resonance; interpolation adds to the damping",
          "half_power_sweep", found.half_power_of_gyroscope),
    Claim("pn-half-power-noise", "3.3, Fig. 4", "scatter of half power, and of the loop, at 5 mV a chip",
          "not compared",
          "open", "the paper does not compare; as long a measurement by either is as good", "half_power_sweep",
          found.half_power_scatter, slow=True),
    Claim("pn-half-power-a", "3.3, Fig. 4", "stiffness and damping by the half-power method, the accelerometer",
          "in words", "fails", "overdamped, it has no peak and no two half-power frequencies", "half_power_sweep",
          found.half_power_of_accelerometer, slow=True),
    Claim("pn-half-power-formula", "3.3", "damping is Df / 2 f0 = 1 / 2Q", "a ratio", "fails",
          "that is the damping ratio; the coefficient of tables 1 and 2 is 2 pi m Df"),
    Claim("pn-quality", "3.3", "Q is the square root of km/c", "sqrt(km/c)", "fails",
          "a misprint for sqrt(km) / c, which is what table 2 has"),
    Claim("pn-table-2", "3.3, Table 2", "quality factors of the gyroscope", "128.8 and 43.63", "differs",
          "they do not follow from the stiffness, mass and damping beside them", CAPACITANCES, found.qualities),
    Claim("pn-capacitances", "3.3, Table 2", "0.36 pF of actuation and 0.6 pF of sensing; 5 um of drive", "5 um",
          "holds", "as combs of 24.4 um of overlap and plates with a gap of 2 um, which are assumed", CAPACITANCES,
          found.capacitances),
    Claim("pn-plates", "3.3, eq. 8", "plates that close their gap drive the gyroscope", "0.36 pF", "differs",
          "a gap of 4 um is assumed, and 1 V; 0.36 pF soften its spring by 8 %, and 5 um would be beyond the gap",
          "vibratory_gyroscope", found.plates_of_the_drive),
    Claim("pn-sensitivity-g", "3.3", "sense mode at 1 deg/s", "143.7 nm", "fails",
          "the unit is a thousand times too large; the number is right within 4 %", CAPACITANCES,
          lambda: f"{1e12 * found.measured('sense_amplitude'):.1f} pm"),
    Claim("pn-mismatch", "3.3, Fig. 9", "0.05 rad/s of mismatch lose 50 %, 4.623 to 1.791 um", "50 %", "fails",
          "its own numbers are another fall, its unit is none of a mismatch; micrometres would take 560 rad/s",
          "gyroscope_rate_response", found.mismatched),
    Claim("pn-tuning", "3.3", "tuning of the two modes is crucial", "in words", "holds",
          "table 2 is 318 Hz out of tune", CAPACITANCES, found.tuned),
    Claim("pn-reciprocal", "3.3, eq. 6, 7", "the reciprocal Coriolis force is negligible", "in words", "holds",
          "both equations print dy/dt; the sense mode feels dx/dt", CAPACITANCES, found.reciprocal),
    Claim("pn-online", "4", "calibration in operation is future work", "future work", "holds",
          "the paper's own loop takes a constant force for a spring: 0.1 g is 6 % of stiffness",
          "self_calibration_in_operation", found.in_operation, slow=True),
    Claim("pn-offset", "2.1 ii", "the static difference gives the stiffness", "in words", "differs",
          "any constant acceleration counts as stiffness", LOOP, found.bias_by_acceleration),
    Claim("pn-three", "1, 3.4", "three axes calibrate independently", "a goal", "holds", "at 8.75 kHz", "imu_3dof",
          found.three_at_once, slow=True),
    Claim("pn-verdicts", "1", "self-test has yield loss and test escape", "in words", "holds",
          "how devices and limits scatter is assumed", "self_test_population", found.self_tested, slow=True),
    Claim("pn-figures", "Fig. 1, 5, 7", "scheme, set-up and photographs", "drawings", "open",
          "they hold no number, and the text that is left does not describe them"),
)  # fmt: skip


def _hardware(
    design: str, letter: str, graph: str, rows: tuple[tuple[str, tuple[str, ...], str], ...]
) -> tuple[Claim, ...]:
    """Rows of table 3 or 4."""
    place = f"3.4, Table {3 if letter == 'a' else 4}"
    return tuple(
        Claim(f"pn-{name.replace(' ', '-')}-{letter}", place, f"{name} of the {design}: slices / FF / LUT / MULT",
          paper, "differs", FLOW, graph, partial(found.hardware, design, *blocks), slow=True)
        for name, blocks, paper in rows
    )  # fmt: skip


HARDWARE = (
    *_hardware("accelerometer", "a", FIXED, (
        ("generator", ("chips",), "12 / 11 / 1 / 0"),
        ("stiffness controller", ("stiffness",), "248 / 58 / 484 / 0"),
        ("damping controller", ("damping",), "207 / 99 / 365 / 0"),
        ("cells", ("cell", "model_cell"), "424 / 127 / 811 / 0"),
        ("model", ("model",), "2618 / 1495 / 4865 / 21"),
        ("all", (), "3547 / 1857 / 6461 / 21"),
    )),
    *_hardware("gyroscope", "g", GYRO_FIXED, (
        ("generator", ("chips",), "12 / 11 / 1 / 0"),
        ("stiffness controller", ("stiffness",), "252 / 58 / 492 / 0"),
        ("damping controller", ("damping",), "175 / 98 / 293 / 0"),
        ("cells", ("cell", "model_cell"), "1694 / 2536 / 2827 / 0"),
        ("model", ("model",), "2533 / 934 / 4646 / 35"),
        ("all", (), "4686 / 3646 / 8275 / 35"),
    )),
    Claim("pn-occupation", "3.4, Tables 3, 4", "percentages of five devices", "33 figures", "holds",
          "", "docs.papers.occupancy", found.occupation),
    Claim("pn-occupation-a", "3.4, Table 3", "the accelerometer's share of an XC2VP30, the scarcest resource",
          "25.89 % of slices", "differs", "fewer slices and registers, as many multipliers", FIXED,
          lambda: found.largest_share(found.occupancy.ours("accelerometer"), "XC2VP30"), slow=True),
    Claim("pn-occupation-g", "3.4, Table 4", "the gyroscope's share of an XC2VP30, the scarcest resource",
          "34.21 % of slices", "differs", "words of the library's graph", GYRO_FIXED,
          lambda: found.largest_share(found.occupancy.ours("gyroscope"), "XC2VP30"), slow=True),
    Claim("pn-axes-theirs", "3.4", "three axes with one generator fit an XC2VP30, by the paper's counts", '"suitable"',
          "holds", "the paper does not add them", "docs.papers.occupancy", found.three_axes_of_the_paper),
    Claim("pn-axes-ours", "3.4", "three axes with one generator fit an XC2VP30, by ours", '"suitable"', "holds",
          "a sum of the graphs in registers; no open tool places this family", FIXED,
          lambda: found.largest_share(found.occupancy.our_three_axes(), "XC2VP30"), slow=True),
    Claim("pn-clock-a", "3.4", "clock of the accelerometer's", "14.217 MHz", "differs",
          "an estimate with delays that no data sheet confirms; two products and a controller within one tick", FIXED,
          partial(found.clock, "accelerometer"), slow=True),
    Claim("pn-clock-g", "3.4", "clock of the gyroscope's", "17.727 MHz", "differs", "as the accelerometer's",
          GYRO_FIXED, partial(found.clock, "gyroscope"), slow=True),
    Claim("pn-pipelining", "3.4", "pipelining can increase the speed", "in words", "open",
          "the model is a feedback loop: a register in it would change what it computes"),
    Claim("pn-latency", "3.4", "all blocks have the same throughput and similar latencies", "in words", "open",
          "neither is given; in the graphs every block takes one tick"),
)  # fmt: skip
CLAIMS = (*BEGINNING, *DEVICES, *HARDWARE)
