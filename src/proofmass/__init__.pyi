from proofmass.blocks.declaration.declare import Block as Block, Buffer as Buffer, Input as Input, block as block, param as param
from proofmass.blocks.declaration.problem import ModelError as ModelError, Problem as Problem
from proofmass.graphs.files.toml_reader import read_graph as read_graph
from proofmass.graphs.files.toml_writer import write_graph as write_graph
from proofmass.graphs.model.build import Graph as Graph
from proofmass.graphs.model.graph import Probe as Probe, Wire as Wire
from proofmass.graphs.model.linear_systems import from_control as from_control, from_scipy as from_scipy
from proofmass.graphs.studies.build import Study as Study
from proofmass.graphs.studies.study_reader import read_study as read_study, read_variants as read_variants
from proofmass.graphs.tuning.reader import read_tuning as read_tuning
from proofmass.graphs.tuning.tuning import Tuning as Tuning
from proofmass.runner.analysis.allan.deviations import Allan as Allan, allan as allan
from proofmass.runner.analysis.linearisation.linearise import linearise as linearise
from proofmass.runner.analysis.margins.margins import Margins as Margins
from proofmass.runner.analysis.margins.second_opinion import second_opinion as second_opinion
from proofmass.runner.analysis.margins.stability import margins as margins
from proofmass.runner.analysis.noise.budget import noise as noise
from proofmass.runner.analysis.noise.noise_budget import NoiseBudget as NoiseBudget
from proofmass.runner.analysis.noise.over_runs import ValueDeviation as ValueDeviation, deviation_over_runs as deviation_over_runs
from proofmass.runner.analysis.response.response import Response as Response, response as response
from proofmass.runner.analysis.several.over import margins_over as margins_over, margins_over_age as margins_over_age
from proofmass.runner.analysis.several.together import margins_together as margins_together
from proofmass.runner.analysis.spectrum.series import Series as Series, read_series as read_series
from proofmass.runner.analysis.spectrum.tones import Tones as Tones, tones as tones
from proofmass.runner.analysis.spectrum.welch import Spectrum as Spectrum, spectrum as spectrum
from proofmass.runner.design.identification.fitted import Fitted as Fitted, fit as fit
from proofmass.runner.design.modulators.modulator import Modulator as Modulator, design_modulator as design_modulator
from proofmass.runner.design.proof.prove import Proofs as Proofs, prove as prove
from proofmass.runner.design.tune.tune import Tuned as Tuned, tune as tune
from proofmass.runner.design.worst.worst import WorstCases as WorstCases, worst as worst
from proofmass.runner.run.faults import RunError as RunError
from proofmass.runner.run.result import Result as Result, Trace as Trace
from proofmass.runner.run.simulate import simulate as simulate
from proofmass.runner.run.sweep import Sweep as Sweep, sweep as sweep
from proofmass.runner.studies.outcome.result import StudyResult as StudyResult
from proofmass.runner.studies.whole.ready import check as check
from proofmass.runner.studies.whole.study import replay as replay, run_study as run_study

__version__: str
