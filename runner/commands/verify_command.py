"""The command `verify`: requirements and golden results of a graph."""

from proofmass.graphs.files.toml_reader import read_table
from proofmass.graphs.studies.study_reader import STUDY, graph_in, is_study, studies_of_table
from proofmass.runner.commands.answers import DONE, WRONG_MODEL, print_answer, print_file, print_text
from proofmass.runner.commands.declarations.comparison import VerifyRequest
from proofmass.runner.commands.graph_options import changed
from proofmass.runner.commands.own_blocks import own_blocks
from proofmass.runner.output.counts import count
from proofmass.runner.verification.golden import compared, golden_file, read_golden, record
from proofmass.runner.verification.verify import Measurements, verify
from proofmass.runner.verification.written import findings_text, save_findings_page, save_junit


def verify_graph(request: VerifyRequest) -> int:
    """Verify a graph, print and write what was found, and return the exit code: 1 where something is missed."""
    own, (data, place) = own_blocks(request.own), read_table(request.graph)
    graph = changed(graph_in(data, place, own, request.graph), request.changes)
    studies = studies_of_table(data, place, graph) if is_study(data) or STUDY in data else {}
    study, variants = next(iter(studies.values()), None), dict(list(studies.items())[1:])
    measurements = Measurements(graph, study, request.engine, request.runs, variants)
    golden = request.golden or golden_file(request.graph)
    if request.record:
        recorded = record(measurements, golden)
        print_text([f"{count(recorded, 'result')} recorded in {golden}"], err=request.as_json)
    findings = verify(measurements)
    if not request.record and (request.golden or golden.is_file()):
        findings += compared(measurements, read_golden(golden))
    met = all(finding.met for finding in findings)
    answer = {"graph": graph.name, "met": met, "requirements": [finding.as_data() for finding in findings]}
    print_answer(request.as_json, lambda: answer, findings_text(findings))
    for path, save in ((request.junit, save_junit), (request.page, save_findings_page)):
        if path is not None:
            print_file(save(path, graph.name, findings), request.as_json)
    return DONE if met else WRONG_MODEL
