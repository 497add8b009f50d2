"""The Coriolis response of a gyroscope to a constant rate, against its closed form and the figure of the paper."""

import math

import pytest

from docs.papers.pn_runs import library, sense_amplitude


class TestRateResponse:
    """Two modes, 5 um of drive, 1 deg/s: y = 2 m W w X / |k - m w^2 + j w c|."""

    @pytest.mark.parametrize(("stiffness", "picometres"), [(122.28, 149.03), (132.23, 41.13), (1.05 * 122.28, 63.08)])
    def test_displacement_against_the_closed_form(self, stiffness: float, picometres: float) -> None:
        amplitude = sense_amplitude(
            library("gyroscope_rate_response.toml").with_parameters({"sense.stiffness": stiffness})
        )
        w = 2.0 * math.pi * 7977.51
        force = 2.0 * 48.67e-9 * math.radians(1.0) * w * 5e-6
        assert amplitude == pytest.approx(force / abs(stiffness - 48.67e-9 * w * w + 1j * w * 57e-6), rel=1e-4)
        assert 1e12 * amplitude == pytest.approx(picometres, rel=1e-3)

    @pytest.mark.parametrize(
        ("percent", "of_tuned"),
        [
            (-10, 0.2275),
            (-5, 0.4234),
            (-2, 0.7597),
            (-1, 0.9193),
            (0, 1.0),
            (1, 0.9194),
            (2, 0.7597),
            (5, 0.4234),
            (10, 0.2275),
        ],
    )
    def test_the_curve_of_mismatch_against_the_closed_form(self, percent: float, of_tuned: float) -> None:
        stiffness, w = 122.28 * (1.0 + percent / 100.0), 2.0 * math.pi * 7977.51
        amplitude = sense_amplitude(
            library("gyroscope_rate_response.toml").with_parameters({"sense.stiffness": stiffness})
        )
        force = 2.0 * 48.67e-9 * math.radians(1.0) * w * 5e-6
        assert amplitude == pytest.approx(force / abs(stiffness - 48.67e-9 * w * w + 1j * w * 57e-6), rel=1e-3)
        assert 1e12 * amplitude / 149.03 == pytest.approx(of_tuned, abs=1e-3)

    def test_a_spring_between_the_modes_answers_in_quadrature(self) -> None:
        """1e-3 N/m: -k x of 5 um, a quarter of a period from -2 m W v; amplitudes add as legs of a right triangle."""
        graph, w = library("gyroscope_rate_response.toml"), 2.0 * math.pi * 7977.51
        coriolis, spring = 2.0 * 48.67e-9 * math.radians(1.0) * w * 5e-6, 1e-3 * 5e-6
        both = sense_amplitude(graph.with_parameters({"coupling.gain": -1e-3}))
        alone = sense_amplitude(graph.with_parameters({"coupling.gain": -1e-3, "rotation.value": 0.0}))
        assert alone == pytest.approx(spring / (w * 57e-6), rel=1e-3)
        assert both == pytest.approx(math.hypot(coriolis, spring) / (w * 57e-6), rel=1e-3)

    def test_the_papers_value_is_met_in_picometres(self) -> None:
        """143.7 nm is printed; with the quality factor of its table 2, 43.63, the graph gives 146.1 pm."""
        tuned = library("gyroscope_rate_response.toml")
        damping = math.sqrt(132.23 * 48.67e-9) / 43.63
        amplitude = sense_amplitude(tuned.with_parameters({"sense.damping": damping}))
        assert 1e12 * amplitude == pytest.approx(146.1, rel=1e-3)
        assert 1e12 * amplitude == pytest.approx(143.7, rel=0.02)
