"""Print how long each sensor of the gallery takes for a second of its own time: python benchmarks/gallery_times.py."""

from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.simulate import simulate

SECONDS = {  # of a run
    "closed_loop_gyroscope": 1.0,
    "open_loop_gyroscope": 1.0,
    "resonant_accelerometer": 0.5,
    "sigma_delta_accelerometer": 0.5,
    "fibre_optic_gyroscope": 0.5,
    "chopped_accelerometer": 1.0,
    "force_balance_seismometer": 10.0,
    "closed_loop_fluxgate": 0.1,
    "six_axis_imu": 100.0,
    "quartz_thermometer": 1.0,
}
RUNS = 5


def main() -> None:
    """Print one line for each sensor: the best of some runs of compiled code on one core."""
    for name, seconds in SECONDS.items():
        graph = read_graph(library_file(f"{name}.toml"))
        simulate(graph, samples=100, engine="compiled")  # compiles
        best = min(simulate(graph, duration=seconds, engine="compiled").seconds for _ in range(RUNS)) / seconds
        rate = float(plan(graph).schedule.base_rate)
        print(f"{name:26} {1e3 * best:8.2f} ms a second, {1e9 * best / rate:6.0f} ns a tick of {rate:9.0f} Hz")


if __name__ == "__main__":
    main()
