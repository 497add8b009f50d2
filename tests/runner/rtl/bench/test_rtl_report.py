"""The report of hardware: what it says in JSON, and that the page has it without asking the network."""

import json
from html.parser import HTMLParser
from pathlib import Path

from proofmass.runner.rtl.bench.report import cost_text, report_data, save_report
from tests.by_hand.machines import loop_at_rates, made
from tests.runner.rtl.text.test_machine_verilog import cut_graph


def test_ports_formats_registers_and_cost_are_said() -> None:
    graph = loop_at_rates()
    machine, vectors = made(graph)
    data = report_data(graph, machine, vectors.clocks)
    assert (data["top"], data["clock"], data["clock_hz"]) == ("top", "6 kHz", 6e3)
    assert (data["latency"], data["vectors"]) == (0, 121)
    (port,) = data["inputs"]
    assert (port["name"], port["signal"], port["format"]) == ("quantiser_output", "quantiser.output", "(16, 12)")
    assert (port["lowest"], port["highest"], port["signed"]) == (-32768, 32767, True)
    assert {each["block"]: each["clocks_per_tick"] for each in data["instances"]} == {
        "error": 1,
        "gain": 2,
        "integrator": 3,
    }
    integrator = next(module for module in data["modules"] if module["kind"] == "FixedIntegrator")
    assert integrator["registers"] == [
        {"name": "total", "of": "x.total", "format": "(32, 28)", "width": 32, "reset": 0}
    ]
    assert integrator["parameters"]["sum_format"] == "(32, 28)"
    assert "proofs" not in data


def test_latency_is_said() -> None:
    machine, vectors = made(cut_graph(1, 3))
    data = report_data(cut_graph(1, 3), machine, vectors.clocks)
    assert data["latency"] == 4
    assert {each["block"]: each["ticks_late"] for each in data["instances"]}["sum"] == 4
    assert data["cost"]["pipeline_bits"] > 4 * 24


def test_the_page_has_all_of_it_and_what_others_found(tmp_path: Path) -> None:
    graph = loop_at_rates()
    machine, vectors = made(graph)
    data = report_data(
        graph, machine, vectors.clocks, {"proofs": {"integrator.total": "proved"}, "resources": {"LUT": 12}}
    )
    paths = save_report(graph, data, tmp_path)
    assert [path.name for path in paths] == ["report.json", "report.html"]
    assert json.loads(paths[0].read_text(encoding="utf-8")) == data
    page = paths[1].read_text(encoding="utf-8")
    HTMLParser().feed(page)
    for text in ("Hardware of loop", "(17, 12)", "Proofs", "proved", "Resources", "x.total", "outputs 0 ticks late"):
        assert text in page
    assert "http:" not in page
    assert "https:" not in page


def test_the_cost_in_one_line() -> None:
    cost = {"register_bits": 8, "pipeline_bits": 0, "adder_bits": 20, "multipliers": {"16 x 2": 2}}
    assert cost_text(cost | {"constant_multipliers": {}}) == "8 register bits, 20 adder bits, multipliers 16 x 2 (2)"
    nothing = {"register_bits": 0, "pipeline_bits": 0, "adder_bits": 0, "multipliers": {}, "constant_multipliers": {}}
    assert cost_text(nothing) == "wires alone"
