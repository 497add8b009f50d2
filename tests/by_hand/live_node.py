"""Runs the loop that a page carries in Node, by the page's own modules."""

import json
import subprocess
from pathlib import Path
from typing import Any

import proofmass.runner.live as live
from tests.by_hand.node import NODE

MODULES = Path(live.__file__).parent
_SCRIPT = """
import fs from 'fs';
const {modules, model, settings, spectrum} = JSON.parse(fs.readFileSync(0));
const {Engine, digest, numbers} = await import(modules + '/engine.mjs');
const {parametersOf} = await import(modules + '/values.mjs');
const figures = await import(modules + '/figures.mjs');
const engine = await Engine.open(model.loop);
const answers = [];
for (const {chunk, named, ...one} of settings) {
  engine.begin({values: parametersOf(model.named, named ?? {}), seed: model.seed, run: 0, ticks: model.ticks, ...one});
  const {ticks} = engine.settings;
  let sound = true;
  while (engine.tick < ticks && sound) sound = engine.advance(Math.min(ticks, engine.tick + (chunk ?? ticks)));
  const traces = engine.traces();
  const answer = {digest: await digest(traces), measures: engine.measures(), sound};
  if (spectrum) answer.spectra = traces.map(t => figures.spectrum(numbers(t), model.loop.rate[0] / model.loop.rate[1]));
  answers.push(answer);
}
const plain = (_, value) => value instanceof Float64Array ? [...value] : Number.isNaN(value) ? null : value;
process.stdout.write(JSON.stringify(answers, plain));
"""


def run_carried(model: dict[str, Any], *settings: dict[str, Any], spectrum: bool = False) -> list[dict[str, Any]]:
    """Digest, measures and, if wanted, spectra of runs of a model with these settings."""
    told = {"modules": MODULES.resolve().as_uri(), "model": model, "settings": settings, "spectrum": spectrum}
    command = [NODE or "", "--input-type=module", "--eval", _SCRIPT]
    done = subprocess.run(command, input=json.dumps(told), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    answers: list[dict[str, Any]] = json.loads(done.stdout)
    return answers
