"""Requirements on a study count all of its variants, in whatever order they stand."""

import json
from pathlib import Path

import pytest

from proofmass.runner.command_line import main

TEXT = """\
name = "a converter"
rate = "1 kHz"
samples = 2
wires = ["source.output -> adc.voltage"]

[measures]
code = { signal = "adc.number", statistic = "mean" }

[requirements]
ALL = { quantity = "yield", at_least = "90 %" }
FEW = { quantity = "yield", at_most = "0 %" }
SPREAD = { quantity = "code", at_least = 6000, tolerances = "spread" }
CODE = { quantity = "code", at_least = 6000 }

[blocks]
source = { kind = "Constant", value = "1 V", unit = "V" }
adc = { kind = "AnalogToDigital", bits = 16, reference = "5 V" }

[study]
runs = 5
spread = { "source.value" = { normal = "1 mV" } }
limits = { code = { at_least = 6000 } }
"""
VARIANTS = '[study.variants]\nfine = {}\ncheap = { set = { "adc.bits" = 12 } }\n'
ORDERS = {
    "swept": 'sweep = { "adc.bits" = [16, 12] }\n',
    "swept backwards": 'sweep = { "adc.bits" = [12, 16] }\n',
    "variants": VARIANTS,
}


@pytest.mark.defect("S903", before="the yield of the first value of a sweep alone", after="of all, the worst is named")
@pytest.mark.parametrize("order", ORDERS)
def test_the_worst_variant_counts(order: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of 1 V to 5 V, 16 bits give a code of 6554 and 12 bits 410: a yield of 1, and one of 0."""
    (tmp_path / "graph.toml").write_text(TEXT + ORDERS[order])
    assert main(["verify", str(tmp_path / "graph.toml"), "--json", "--engine", "python"]) == 1
    found = {entry["id"]: entry for entry in json.loads(capsys.readouterr().out)["requirements"]}
    assert (found["ALL"]["value"], found["ALL"]["met"]) == (0.0, False)
    assert (found["FEW"]["value"], found["FEW"]["met"]) == (1.0, False)
    assert found["SPREAD"]["value"] == pytest.approx(410, abs=2)
    assert not found["SPREAD"]["met"]
    assert found["CODE"]["met"], "a measure is that of the graph"
    cheap = {"swept": "adc.bits = 12", "swept backwards": "", "variants": "cheap"}[order]
    assert found["ALL"]["reason"] == (f"in the variant {cheap}" if cheap else "")
    assert found["FEW"]["reason"] == ("" if cheap else "in the variant adc.bits = 16")
