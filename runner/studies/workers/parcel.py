"""A study packed for other machines: its text and the files that it needs.

Neither compiled code nor objects travel: the receiver reads the text, plans and compiles.
"""

import hashlib
from dataclasses import dataclass
from pathlib import Path

from proofmass.blocks.declaration.catalog import load_own_blocks, own_file
from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.files.toml_reader import parsed
from proofmass.graphs.model.changes import with_recordings
from proofmass.graphs.studies.study import Study
from proofmass.graphs.studies.study_reader import read_study_text
from proofmass.graphs.studies.study_writer import files_beside, write_study
from proofmass.runner.host.versions import PROOFMASS
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.provenance import graph_text
from proofmass.runner.studies.runs.facts import facts_of
from proofmass.runner.studies.runs.sensor_runs import SensorRuns


class ParcelError(RuntimeError):
    """A parcel that cannot be unpacked here; only a text, which survives the way back."""


@dataclass(frozen=True)
class Parcel:
    """A study, how its runs are computed, and a hash of facts, equal wherever it is unpacked."""

    text: str
    files: tuple[tuple[str, bytes], ...]  # recordings, long lists, named by hash; own blocks
    own: tuple[str, ...]  # names of the files of own blocks
    engine: EngineName
    lanes: int
    version: str
    facts: str  # hash of the facts that determine the bits


def packed(sensors: SensorRuns) -> Parcel:
    """Return the study of these sensors.

    Raises `ModelError` for own blocks that no file declares, and for more text than may be read;
    `OSError`.
    """
    study = sensors.study
    own_files, files = _own_files(study), files_beside(study)
    files |= {path.name: path.read_bytes() for path in own_files}

    def by_content(folder: str, file: str) -> str:
        path = Path(folder) / file
        content = path.read_bytes()
        name = hashlib.sha256(content).hexdigest() + path.suffix
        files[name] = content
        return name

    graph = with_recordings(study.graph, "", by_content)
    facts = _digest(facts_of(sensors) | {"graph": graph_text(graph)})
    text = write_study(study, graph)
    _refuse_unreadable(text)
    names = tuple(path.name for path in own_files)
    return Parcel(text, tuple(files.items()), names, sensors.engine, sensors.lanes, PROOFMASS, facts)


def unpacked(parcel: Parcel, folder: Path) -> SensorRuns:
    """Return the sensors of a parcel, and write its files into the folder. Raises `ParcelError`, `OSError`."""
    if parcel.version != PROOFMASS:
        raise ParcelError(f"proofmass {PROOFMASS} is installed there, and {parcel.version} here")
    for name, content in parcel.files:
        if name not in parcel.own and hashlib.sha256(content).hexdigest() != Path(name).stem:
            raise ParcelError(f"the file {name} has been damaged on its way")
        (folder / name).write_bytes(content)
    own = {kind: block for name in parcel.own for kind, block in load_own_blocks(folder / name).items()}
    try:
        study = read_study_text(parcel.text, "the study", own, str(folder))
        sensors = SensorRuns(study, parcel.engine, parcel.lanes)
    except ModelError as error:
        raise ParcelError(str(error)) from None
    if _digest(facts_of(sensors)) != parcel.facts:
        raise ParcelError("its blocks compute something different from those here; install the same proofmass")
    return sensors


def _own_files(study: Study) -> list[Path]:
    """Return the files that declare own blocks of the graph."""
    kinds = {type(block) for block in study.flat.blocks.values()}
    files = {kind: own_file(kind) for kind in kinds if not kind.__module__.startswith("proofmass.blocks.")}
    for kind, file in files.items():
        if file is None:
            message, hint = "a block declared here cannot travel to workers", "put it into a file: --blocks FILE.py"
            raise Problem(message=message, key="blocks", got=kind.__name__, hint=hint).error
    return sorted({file for file in files.values() if file})


def _refuse_unreadable(text: str) -> None:
    """Raise `ModelError` for more text than a worker reads: several files are one text here."""
    try:
        parsed(text, "", ".")
    except ModelError as error:
        message, hint = "the study and its graph are too large for workers", "run it here, without --dask"
        raise Problem(message=message, key="dask", got=error.problems[0].message, hint=hint).error from None


def _digest(facts: dict[str, str]) -> str:
    return hashlib.sha256(repr(sorted(facts.items())).encode()).hexdigest()
