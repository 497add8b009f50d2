"""Values and units of the product."""

from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks import Product
from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.units import same_unit
from tests.by_hand.functions import drive

finite = st.floats(allow_nan=False, allow_infinity=False)


@given(finite, finite)
def test_product_is_the_float_product(first: float, second: float) -> None:
    assert drive(Product(), [{"first": first, "second": second}])[0]["output"] == first * second


def test_unit_of_the_output() -> None:
    block = Product(first_unit="kg", second_unit="m/s^2")
    assert same_unit(unit_of(block, type(block).outputs["output"]), "N")
    assert unit_of(block, type(block).inputs["first"]) == "kg"
    assert Product.feedthrough("output") == ("first", "second")
