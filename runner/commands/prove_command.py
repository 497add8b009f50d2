"""The commands `prove` and `check-proof`: margins over tolerances as theorems, and certificates."""

from dataclasses import replace

from proofmass.graphs.files.toml_reader import graph_from
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.studies.study import Study
from proofmass.runner.commands.answers import DONE, INTERRUPTED, WRONG_MODEL, print_answer, print_file
from proofmass.runner.commands.declarations.design import CheckProofRequest, ProveRequest
from proofmass.runner.commands.graph_options import toleranced
from proofmass.runner.commands.named_options import by_name, read_tolerance
from proofmass.runner.commands.progress import progress
from proofmass.runner.design.proof.attempt import KnownProofs, known_proofs
from proofmass.runner.design.proof.prove import prove
from proofmass.runner.design.proof.text import proofs_text
from proofmass.runner.output.export import write_whole
from proofmass.runner.verification.certificates import ASSUMED, certificate, graph_digest, graph_of_certificate
from proofmass.runner.verification.proof_checker import FalseCertificateError, check_certificate


def show_proofs(request: ProveRequest) -> int:
    """Prove the margins of a graph and return the exit code: 1 if one is not proved."""
    source, left_out = toleranced(request.source, request.own, request.changes)
    with progress(request.quiet or request.as_json, "claim") as bar:
        proofs = request.call(
            prove,
            source,
            tolerances=by_name("--tolerance", map(read_tolerance, request.tolerances)),
            input=request.source_signal,
            scale_factor=by_name("--scale-factor", map(_limits, request.scale_factors)),
            bias=by_name("--bias", map(_limits, request.biases)),
            constants=by_name("--constant", map(_limits, request.constants)),
            peak=by_name("--peak", map(_limits, request.peaks)),
            noise=by_name("--noise", map(_limits, request.noises)),
            rounding=by_name("--rounding", map(_limits, request.roundings)),
            input_ranges=by_name("--input-range", map(_limits, request.input_ranges)),
            slow_change=by_name("--slow-change", map(_rate, request.slow_changes)),
            progress=bar,
            known=_known(request, source),
        )
    proofs = replace(proofs, left_out={**proofs.left_out, **left_out})
    print_answer(request.as_json, proofs.as_data, [proofs_text(proofs)])
    if request.target is not None:
        print_file(write_whole(request.target, certificate(proofs)), request.as_json)
    run = next((proof.run for proof in proofs.digital if proof.run is not None), None)
    if request.counterexample is not None and run is not None:
        print_file(write_whole(request.counterexample, write_graph(run.graph)), request.as_json)
    return INTERRUPTED if proofs.interrupted else DONE if proofs.proved else WRONG_MODEL


def check_proof(request: CheckProofRequest) -> int:
    """Check a certificate and return the exit code: 1 if it proves nothing, or of another graph."""
    text = request.certificate.read_text(encoding="utf-8", errors="replace")
    try:
        claims = check_certificate(text)
        same = request.graph is None or graph_of_certificate(text) == graph_digest(graph_from(request.graph))
        fault = "" if same else "is that of another graph"
    except FalseCertificateError as error:
        claims, fault = [], str(error)
    if fault:
        print_answer(request.as_json, lambda: {"valid": False, "why": fault}, [f"{request.certificate}: {fault}"])
        return WRONG_MODEL
    lines = ["proved", *(f"  {claim}" for claim in claims), "taken for granted", *(f"  {one}" for one in ASSUMED)]
    data = {"valid": True, "claims": claims, "assumed": ASSUMED}
    print_answer(request.as_json, lambda: data, lines)
    return DONE


def _limits(text: str) -> tuple[str, str]:
    """Return the output and the limits of an option such as `adc.number=1.9..2.1`."""
    output, _, limits = text.partition("=")
    return output.strip(), limits.strip()


def _rate(text: str) -> tuple[str, str]:
    """Return the parameter and the rate of an option such as `torquer.gain=1 %/s`; "" for all parameters."""
    name, _, rate = text.rpartition("=")
    return name.strip(), rate.strip()


def _known(request: ProveRequest, source: Graph | Study) -> KnownProofs | None:
    """Return what the certificate has already that is to be written."""
    if request.target is None or not request.target.is_file():
        return None
    graph = source.graph if isinstance(source, Study) else source
    return known_proofs(request.target.read_text(encoding="utf-8", errors="replace"), graph_digest(graph))
