"""Live pages in the system's Chromium: `python -m benchmarks.live_pages [--json]`.

- From a save of a graph of 31 blocks to new traces on the page: with another wiring, and with other numbers alone.
- From a slider that is set to verdicts of its loops: the margins of the tutorial's loop, of another gain each time.
- What a page works for each frame while a slider is dragged, of traces with 100,000 points.
- Workload W1, a million samples of the closed-loop accelerometer: the run on the page over the native one.

Rounds are repeated and the least is taken, since machines are shared; medians stand beside it. Frames are drawn by
software: the work of the page itself is what Chromium counts for the page's own thread, not for its compositor.
"""

import argparse
import contextlib
import json
import os
import re
import statistics
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from proofmass import read_graph
from proofmass.graphs.files.library import library_file
from proofmass.runner.commands.run_files import write_run
from proofmass.runner.plan.memory import start
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.simulate import simulate
from proofmass.runner.targets.native import CompiledLoop
from tests.by_hand.chromium import CHROMIUM, FLAGS, Process

POINTS, SAMPLES = 100_000, 1_000_000
LIMITS = {
    "save, other wiring": 1.0,
    "save, other numbers": 0.3,
    "slider to verdicts": 0.5,
    "work of a frame": 0.016,
    "W1, page over native": 1.6,
}
_DONE = """() => new Promise(resolve => {
  const status = document.querySelector('#live .status');
  const watch = new MutationObserver(() => {
    if (!/ticks in/.test(status.textContent)) return;
    watch.disconnect();
    requestAnimationFrame(() => resolve(Date.now()));
  });
  watch.observe(status, {childList: true});
})"""
_JUDGED = """(place) => new Promise(resolve => {
  const range = document.querySelector("[aria-label='pid.integral, slider']");
  const chip = document.querySelector('.chip[data-of=main] span'), began = performance.now();
  const watch = new MutationObserver(() => {
    if (chip.textContent === before) return;
    watch.disconnect();
    requestAnimationFrame(() => resolve(performance.now() - began));
  });
  const before = chip.textContent;
  watch.observe(chip, {childList: true, characterData: true, subtree: true});
  range.value = String(place);
  range.dispatchEvent(new Event('input'));
})"""
_DRAG = """(frames) => new Promise(resolve => {
  const range = document.querySelector("[aria-label='pickoff.gain, slider']");
  const status = document.querySelector('#live .status');
  let drawn = 0, asked = 0;
  const began = performance.now();
  const watch = new MutationObserver(() => { drawn += 1; });
  watch.observe(status, {childList: true});
  const next = () => {
    if (asked === frames) {
      watch.disconnect();
      return resolve({drawn, milliseconds: performance.now() - began});
    }
    asked += 1;
    range.value = String(400 + (asked % 200));
    range.dispatchEvent(new Event('input'));
    requestAnimationFrame(next);
  };
  next();
})"""


def main() -> None:
    """Measure, print, and say whether the limits are kept."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--rounds", type=int, default=7)
    arguments = parser.parse_args()
    if CHROMIUM is None:
        raise SystemExit("no chromium on this machine")
    # start-up time: for want of Chromium nothing of it is needed
    from playwright.sync_api import sync_playwright

    with sync_playwright() as made, tempfile.TemporaryDirectory() as folder:
        browser = made.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        rows = [
            *saves(browser, Path(folder), arguments.rounds),
            verdicts(browser, arguments.rounds),
            *frames(browser, Path(folder), arguments.rounds),
            in_the_browser(browser, Path(folder), arguments.rounds),
        ]
        browser.close()
    if arguments.json:
        print(json.dumps(rows, indent=2))
        return
    print(f"{'what':24} {'least':>9} {'median':>9} {'limit':>7}")
    for row in rows:
        limit = LIMITS.get(row["what"])
        kept = "" if limit is None else "kept" if row["least"] <= limit else "missed"
        print(
            f"{row['what']:24} {row['least']:9.4g} {row['median']:9.4g} {limit or '':>7} {kept} {row.get('note', '')}"
        )


def row(what: str, values: list[float], note: str) -> dict[str, Any]:
    """A row of the answer: the least and the median of the rounds."""
    return {"what": what, "least": min(values), "median": statistics.median(values), "note": note}


def saves(browser: Any, folder: Path, rounds: int) -> list[dict[str, Any]]:
    """Seconds from the save of a file until its traces are drawn."""
    text = library_file("chopped_accelerometer.toml").read_text(encoding="utf-8")
    file = folder / "chopped.toml"
    file.write_text(text)
    blocks = read_graph(file).size.blocks
    process = Process(file)
    try:
        page = browser.new_page(viewport={"width": 1400, "height": 900})
        page.goto(process.url)
        page.wait_for_selector(".bits:has-text('SHA-256')", timeout=60_000)
        wired = [_seconds(page, file, _wired_otherwise(text, number)) for number in range(1, rounds + 1)]
        changed = text.replace("seed = 1\n", "", 1)
        length = 'duration = "0.2 s"'
        numbers = [
            _seconds(page, file, changed.replace(length, f"{length}\nseed = {number + 5}")) for number in range(rounds)
        ]
        page.close()
    finally:
        process.kill()
    return [
        row("save, other wiring", wired, f"s, {blocks} blocks and more"),
        row("save, other numbers", numbers, f"s, {blocks} blocks"),
    ]


def _wired_otherwise(text: str, number: int) -> str:
    """The graph with more gains behind an output, so that no module is known."""
    names = [f"more_{i}" for i in range(number)]
    ends = ["plain_output.output", *(f"{name}.output" for name in names)]
    wires = "".join(f'    "{end} -> {name}.input",\n' for end, name in zip(ends, names, strict=False))
    unit = 'input_unit = "m/s^2"\noutput_unit = "m/s^2"\n'
    tables = "".join(f'\n[blocks.{name}]\nkind = "Gain"\ngain = 1.5\n{unit}' for name in names)
    return text.replace("wires = [\n", f"wires = [\n{wires}", 1) + tables


def _seconds(page: Any, file: Path, text: str) -> float:
    handle = page.evaluate_handle(f"() => ({{promise: ({_DONE})()}})")
    began = time.time()
    file.write_text(text)
    ended = page.evaluate("held => held.promise", handle)
    time.sleep(0.6)  # until hashes are made
    return float(ended / 1000.0 - began)


def verdicts(browser: Any, rounds: int) -> dict[str, Any]:
    """Seconds from a move of a slider until the margins of the loop for it are in the strip."""
    process = Process(library_file("closed_loop_accelerometer.toml"))
    try:
        page = browser.new_page(viewport={"width": 1400, "height": 900})
        page.goto(process.url)
        page.wait_for_selector(".chip[data-of=main]:has-text('stable')", timeout=60_000)
        page.wait_for_selector(".strip:not(.waiting)", timeout=60_000)
        page.click("summary:text-is('pid')")
        seconds = [page.evaluate(_JUDGED, 520 + 10 * number) / 1000.0 for number in range(rounds + 1)][1:]
        page.close()
    finally:
        process.kill()
    return row("slider to verdicts", seconds, "s, margins of the closed-loop accelerometer")


def frames(browser: Any, folder: Path, rounds: int) -> list[dict[str, Any]]:
    """Work of the page's own thread for each frame that is drawn while a slider moves."""
    page = _report(browser, folder, POINTS)
    page.click("summary:text-is('pickoff')")
    client = page.context.new_cdp_session(page)
    client.send("Performance.enable")
    work, rates, spent = [], [], []
    for _ in range(rounds):
        before = _thread_seconds(client)
        told = page.evaluate(_DRAG, 120)
        work.append((_thread_seconds(client) - before) / max(1, told["drawn"]))
        rates.append(1000.0 * told["drawn"] / told["milliseconds"])
        page.wait_for_selector(".status:has-text('ticks in')")
        spent.append(float(re.findall(r"in ([\d.]+) ms", page.inner_text("#live .status"))[0]) / 1000.0)
    page.context.close()
    note = f"s of the page, {POINTS:,} points; {max(rates):.0f} frames a second were drawn here"
    return [row("work of a frame", work, note), row("run of a frame", spent, "s, in the worker beside it")]


def _thread_seconds(client: Any) -> float:
    """Seconds that the page's thread has worked: scripts, styles, layout, painting."""
    metrics = {metric["name"]: metric["value"] for metric in client.send("Performance.getMetrics")["metrics"]}
    return float(metrics["TaskDuration"])


def in_the_browser(browser: Any, folder: Path, rounds: int) -> dict[str, Any]:
    """Loop of W1 in the page's worker, on the clock, over CPU time of the native one."""
    graph = read_graph(library_file("closed_loop_accelerometer.toml"))
    planned = plan(graph)
    rows = [np.zeros((p.rows(0, SAMPLES), *p.shape), dtype=p.dtype) for p in planned.probes]
    page = _report(browser, folder, SAMPLES)
    native, loop, whole = list[float](), list[float](), list[float]()
    for number in range(3 * rounds):
        engine = CompiledLoop(planned, 0, memory=start(planned))
        began = time.thread_time()
        engine.advance(SAMPLES, rows)
        native.append(time.thread_time() - began)
        handle = page.evaluate_handle(f"() => ({{promise: ({_DONE})()}})")
        before = _worker_seconds()
        page.fill("[id='run-seed']", str(number + 10))
        page.press("[id='run-seed']", "Enter")
        page.evaluate("held => held.promise", handle)
        whole.append(_worker_seconds() - before)
        loop.append(float(page.get_attribute("#live .status", "data-loop")) / 1000.0)
        time.sleep(0.4)  # until hashes are made
    page.context.close()
    a, b, c = (min(times) * 1e9 / SAMPLES for times in (loop, native, whole))
    paired = [page_time / own for page_time, own in zip(loop, native, strict=True)]
    note = f"{a:.1f} ns over {b:.1f} ns a sample; {c:.1f} ns with copies, envelope and messages"
    return {"what": "W1, page over native", "least": a / b, "median": statistics.median(paired), "note": note}


def _worker_seconds() -> float:
    """CPU seconds of the workers of the pages that this process opened."""
    parents = {}
    for status in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            parents[int(status.parent.name)] = int(status.read_text().rpartition(")")[2].split()[1])
    total = 0
    for number in parents:
        above = number
        while above in parents and above != os.getpid():
            above = parents[above]
        if above == os.getpid():
            total += sum(map(_nanoseconds, Path(f"/proc/{number}/task").glob("*")))
    return total / 1e9


def _nanoseconds(task: Path) -> int:
    with contextlib.suppress(OSError):
        if (task / "comm").read_text().startswith("DedicatedWorker"):
            return int((task / "schedstat").read_text().split()[0])
    return 0


def _report(browser: Any, folder: Path, samples: int) -> Any:
    """The live report of the closed-loop accelerometer, opened."""
    graph = read_graph(library_file("closed_loop_accelerometer.toml"))
    place = folder / f"report_{samples}"
    place.mkdir()
    write_run(simulate(graph, samples=samples), place, (), live=True)
    page = browser.new_context(viewport={"width": 1400, "height": 900}).new_page()
    page.goto((place / "report.html").as_uri())
    page.wait_for_selector(".bits:has-text('SHA-256')", timeout=60_000)
    return page


if __name__ == "__main__":
    main()
