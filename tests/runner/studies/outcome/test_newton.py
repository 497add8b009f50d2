"""Newton's method and differences under Weibull's law, on losses whose derivatives are known."""

import numpy as np

from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.studies.outcome.weibull import _gradient, _information, _inverse, _minimum

CURVED = np.array([[4.0, 1.0], [1.0, 6.0]])
LEAST = np.array([0.5, -0.25])


def bowl(at: AnyArray) -> float:
    return float(0.5 * (at - LEAST) @ CURVED @ (at - LEAST))


def test_differences_of_a_quadratic_are_its_derivatives() -> None:
    at = LEAST + np.array([1.0, 2.0])
    np.testing.assert_allclose(_gradient(bowl, at), [6.0, 13.0], rtol=1e-6)
    np.testing.assert_allclose(_information(bowl, at), CURVED, rtol=1e-4)


def test_the_least_loss_of_a_quadratic_is_found_from_afar() -> None:
    np.testing.assert_allclose(_minimum(bowl, LEAST + np.array([3.0, -5.0])), LEAST, atol=1e-5)


def test_a_loss_that_curves_down_where_it_begins_is_descended() -> None:
    def wells(at: AnyArray) -> float:
        return float((at[0] ** 2 - 1.0) ** 2 + at[1] ** 2)

    np.testing.assert_allclose(_minimum(wells, np.array([0.1, 1.0])), [1.0, 0.0], atol=1e-4)


def test_only_a_positive_definite_matrix_has_an_inverse() -> None:
    found = _inverse(CURVED)
    assert found is not None
    np.testing.assert_allclose(found, np.array([[6.0, -1.0], [-1.0, 4.0]]) / 23.0)
    for matrix in (
        [[-1.0, 0.0], [0.0, -1.0]],
        [[1.0, 2.0], [2.0, 1.0]],
        [[1.0, 1.0], [1.0, 1.0]],
        [[np.inf, 0], [0, 1]],
    ):
        assert _inverse(np.array(matrix)) is None
