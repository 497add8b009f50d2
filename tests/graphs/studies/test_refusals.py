"""What a study or its variants cannot mean: refused at its line, with what was meant or expected."""

from pathlib import Path

import pytest

from proofmass.blocks.declaration.problem import ModelError, Refusal
from proofmass.graphs.studies import empirical
from proofmass.graphs.studies.missions import read_mission
from proofmass.graphs.studies.study_reader import read_study_text
from proofmass.graphs.studies.variants import MOST_VARIANTS
from tests.by_hand.design_texts import INTEGRATING
from tests.by_hand.graph_texts import changed, line_of, problems_of
from tests.by_hand.study_texts import CALIBRATED, STUDY

LOOP = (
    INTEGRATING
    + '[study]\nruns = 4\nmargins = "0 s"\n[study.spread]\n"plant.gain" = { uniform = 0.1, relative = true }\n'
)
LIMITS = "[study.limits]"
SPREAD = (
    '[study.spread]\n"adc.reference" = { normal = "200 ppm", relative = true }\n"source.value" = { uniform = "1 mV" }\n'
)


def only_problem(text: str, at: str) -> str:
    """The one problem of a text, which must be at the line of a piece of it."""
    (problem,) = (problem for problem in problems_of(text) if not problem.note)
    place, _, said = str(problem).partition(": ")
    assert place == f"model.toml:{line_of(text, at)}"
    return said


@pytest.mark.parametrize(
    ("old", "new", "at", "said", "words"),
    [
        ("{ ramp =", '{ mission = "car", ramp =', "mission =", 'drift."adc.reference".mission: no law', "cycles"),
        ("runs = 6", "runs = 4000000000", "runs =", "runs: too large", "at most 4.29497e+09 runs"),
        ("runs = 6", 'margins = "0 s"', "margins =", "margins: the graph names no loops", "add [loops.main] to it"),
        ("runs = 6", 'margins = "soon"', "margins =", "margins: not a number followed by a unit", "soon"),
        ("at_most = 100", 'at_most = 100, from = "1 V"', 'from = "1 V"', "limits.noise.from: V is", "give it in s"),
        ("[study.limits]", "[study.limits]\nnone = 5", "none = 5", "limits.none: there is no", "Otherwise add none"),
        ('uniform = "1 mV"', 'uniform = "5 foo"', "5 foo", 'spread."source.value".uniform: unknown', "give it in V"),
        ('uniform = "1 mV"', 'uniform = "5 %"', "5 %", 'spread."source.value".uniform: % is 1', "needs relative ="),
        (SPREAD, "spread = 5\n", "spread = 5", "spread: must be a table", "What differs from sensor to sensor"),
        (SPREAD, 'design = "sobol"\n', "design =", "design: there is nothing to draw", "What differs from sensor"),
        ("[study.limits]", f"[study.variants]\n{LIMITS}", "[study.variants]", "variants: must be a table", "cheap = {"),
        ("[study.limits]", f"[study.variants.a]\nspread = 5\n{LIMITS}", "[study.var", "variants.a.spread: must", "set"),
    ],
)  # fmt: skip
def test_an_entry_of_a_study(old: str, new: str, at: str, said: str, words: str) -> None:
    text = changed(STUDY, old, new) + '[study.missions]\ncar = { phases = [{ temperature = "300 K", for = "1 h" }] }\n'
    told = only_problem(text, at)
    assert told.startswith(said)
    assert words in told


@pytest.mark.parametrize("name", ["run", "epoch", "age", "recalibration", "fault"])
@pytest.mark.defect("C884", before="an error inside behind all runs, or two columns of a name", after="refused")
def test_a_measure_has_no_name_of_a_column(name: str) -> None:
    text = changed(STUDY, "[measures]\n", f'[measures]\n{name} = {{ signal = "adc.code", statistic = "max" }}\n')
    told = only_problem(text, f"{name} =")
    assert told.startswith(f"measures.{name}: the name is taken: tables of a study have a column of it")
    of_change = changed(STUDY, LIMITS, f'[study.changes]\n{name} = {{ measure = "bias" }}\n{LIMITS}')
    assert only_problem(of_change, f"{name} = {{ measure").startswith(f"changes.{name}: the name is taken")


def test_a_parameter_named_by_its_export_and_by_its_block() -> None:
    text = changed(STUDY, "probes =", 'exports = { scale = "adc.reference" }\nprobes =')
    text = changed(text, "[study.spread]\n", '[study.spread]\n"scale" = { normal = "1 ppm", relative = true }\n')
    told = only_problem(text, '"adc.reference" = { normal')
    assert told == 'spread."adc.reference": the parameter is named twice'


@pytest.mark.defect("S812", before="hinted at dac.voltage, whatever the graph has", after="names a wire of the graph")
@pytest.mark.parametrize(("text", "output"), [(STUDY, "filter.output"), (CALIBRATED, "corrected.output")])
def test_margins_without_a_loop_hint_at_a_wire_of_the_graph(text: str, output: str) -> None:
    """In order of their names; of the second graph the wires of the loop of its register come first."""
    told = only_problem(changed(text, "[study]", '[study]\nmargins = "0 s"'), "margins =")
    assert told.endswith(f'add [loops.main] to it with open_at = "{output}"')


def test_a_name_of_a_change() -> None:
    told = only_problem(f'{STUDY}\n[study.changes]\nDrift = {{ measure = "bias" }}\n', "Drift =")
    assert told.startswith("changes.Drift: not a name\n  got:      'Drift'\n  expected: at most 64 lower-case letters")


def test_a_number_of_a_fixed_point_block() -> None:
    wires = '"source.output -> quantiser.input",\n    "quantiser.output -> scale.input",\n    "filter.output ->'
    blocks = 'quantiser = { kind = "FixedQuantiser", unit = "V" }\n'
    blocks += 'scale = { kind = "FixedGain", input_unit = "V", output_unit = "V" }\nadc = {'
    text = changed(changed(STUDY, '"filter.output ->', wires), "adc = {", blocks)
    told = only_problem(changed(text, '"source.value" = {', '"scale.gain" = {'), '"scale.gain" = {')
    assert told.startswith("spread.\"scale.gain\": the block works in fixed point\n  got:      'scale.gain'")
    assert "make a study of each" in told


def test_a_calibration_carries_measures_by_name() -> None:
    old = CALIBRATED.partition("[study.recalibration")[2].partition("carried = ")[2].partition("\n")[0]
    name = old.partition('"')[2].partition('"')[0]
    told = only_problem(changed(CALIBRATED, old, f'{{ "{name}" = 5 }}'), f'{{ "{name}" = 5 }}')
    assert told == f'recalibration.carried."{name}": must be the name of a measure\n  got:      5'


@pytest.mark.parametrize(
    ("limit", "key", "said", "words"),
    [
        ('"main.stable" = { at_least = "stabel" }', "at_least", "there is no such verdict", "'stable'"),
        ('"main.gain_margin" = { at_least = "6 V" }', "at_least", "not a ratio in decibels", 'write it as "6 dB"'),
    ],
)
def test_a_limit_of_a_margin(limit: str, key: str, said: str, words: str) -> None:
    told = only_problem(f"{LOOP}[study.limits]\n{limit}\n", limit)
    name = limit.partition(" =")[0]
    assert told.startswith(f"limits.{name}.{key}: {said}")
    assert words in told


def test_variants_replace_numbers_and_are_not_too_many() -> None:
    def text(count: int) -> str:
        return changed(
            STUDY,
            "[study.limits]",
            "".join(f"[study.variants.v{n}]\nruns = {n + 2}\n" for n in range(count)) + "[study.limits]",
        )

    assert problems_of(text(2)) == []
    assert problems_of(text(MOST_VARIANTS)) == []
    told = only_problem(text(MOST_VARIANTS + 1), "[study.variants.v0]")
    assert told == "variants: too many variants\n  got:      101\n  expected: at most 100"


@pytest.mark.parametrize(
    ("mission", "said"),
    [
        ({"time": "time", "temperature": "time"}, "time and temperature are one column"),
        ({}, "too cold"),
    ],
)
def test_a_mission_from_a_file(mission: dict[str, str], said: str, tmp_path: Path) -> None:
    (tmp_path / "car.csv").write_text("time [h],temperature [K]\n0,-5\n24,300\n")
    with pytest.raises(Refusal, match=said):
        read_mission({"file": "car.csv", **mission}, str(tmp_path))


def test_a_file_that_is_too_large(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    size = (tmp_path / "lot.csv").write_text("offset\n1\n2\n")
    monkeypatch.setattr(empirical, "LARGEST_FILE", size)
    assert empirical.read_columns("lot.csv", [("offset", "V")], str(tmp_path)) == [[1.0, 2.0]]
    monkeypatch.setattr(empirical, "LARGEST_FILE", size - 1)
    with pytest.raises(Refusal, match="the file is too large"):
        empirical.read_columns("lot.csv", [("offset", "V")], str(tmp_path))


def test_other_numbers_and_limits_of_a_study() -> None:
    study = read_study_text(STUDY)
    with pytest.raises(ModelError, match="runs: too large"):
        study.changed(runs=4_000_000_000, seed=1)
    assert study.changed(runs=7, seed=1).runs == 7
    assert study.with_limits({}).limits == {}
    assert study.limits.keys() == {"bias", "noise"}


def test_what_follows_from_a_value_that_drifts_ages_with_it() -> None:
    text = changed(STUDY, "[blocks]", '[values]\nlevel = "1 V"\nnext = "= 2 * level"\n[blocks]')
    text = changed(
        changed(text, 'value = "1 V"', 'value = "= level"'),
        'density = "1 mV/sqrt(Hz)"',
        'density = "= next / 1 kHz^0.5"',
    )
    text = changed(
        changed(text, '"adc.reference" = { ramp =', '"level" = { ramp ='),
        '"source.value" = {',
        '"adc.offset_error" = {',
    )
    assert read_study_text(text).ageing == {"level", "next", "source.value", "noise.density"}
