"""What counting and writing a study costs, beside its runs: `python -m benchmarks.study_counting [RUNS]`.

CPU seconds for 100,000 runs at 4 ages: the runs, the summary with its intervals, yields, influences and files.
"""

import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from proofmass import Study, run_study
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown.export import save_study_csv, save_study_netcdf, save_study_parquet
from proofmass.runner.studies.shown.influences import StudyInfluences
from proofmass.runner.studies.shown.report import save_study_report

PARTS = "abcdef"
RUNS = 100_000


def study(runs: int) -> Study:
    """Return a study of six values of a tick, four of which drift, with two limits."""
    lines = ['name = "sums and products"', 'rate = "1 kHz"', "samples = 1", "[blocks]"]
    lines += [f'{part} = {{ kind = "Constant", value = {1 + n / 10} }}' for n, part in enumerate(PARTS)]
    lines += ["[measures]", *(f'of_{part} = {{ signal = "{part}.output", statistic = "last" }}' for part in PARTS)]
    lines += ['total = "= of_a*of_b + of_c*of_d"', 'other = "= of_e + of_f*of_a"']
    return Study(
        read_graph_text("\n".join(lines) + "\n"),
        runs=runs,
        spread={f"{part}.value": {"normal": "5 %", "relative": True} for part in PARTS},
        epochs={"ages": [f"{age} year" for age in (0, 1, 3, 10)]},
        drift={
            f"{part}.value": {"ramp": "1 %/year", "ramp_spread": "1 %/year", "random_walk": "0.01 1/sqrt(year)"}
            for part in PARTS[:4]
        },
        limits={"total": {"at_most": 6.0}, "other": {"at_most": 5.0}},
    )


def steps(result: StudyResult, folder: Path) -> dict[str, Callable[[], object]]:
    """Return what is done with a result, by name."""
    return {
        "summary": result.summary,
        "yields": result.yield_intervals,
        "influences": lambda: StudyInfluences(result).rows(),
        "netCDF": lambda: save_study_netcdf(result, folder / "study.nc"),
        "Parquet": lambda: save_study_parquet(result, folder / "study.parquet"),
        "CSV": lambda: save_study_csv(result, folder / "study.csv"),
        "report": lambda: save_study_report(result, folder / "report.html"),
    }


def _timed(step: Callable[[], object]) -> float:
    began = time.process_time()
    step()
    return time.process_time() - began


def main(runs: int) -> None:
    """Print the CPU seconds of each step."""
    began = time.process_time()
    result = run_study(study(runs), threads=1)
    print(f"{'runs':12}{time.process_time() - began:8.2f} s of CPU, {runs:,} runs x {len(result.study.epochs)} ages")
    with tempfile.TemporaryDirectory() as folder:
        for name, step in steps(result, Path(folder)).items():
            print(f"{name:12}{_timed(step):8.2f}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else RUNS)
