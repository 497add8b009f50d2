"""The profile of a run as text."""

from collections.abc import Iterator

from proofmass.runner.commands.texts.times import time_text
from proofmass.runner.output.text_table import text_table
from proofmass.runner.run.profile import Profile


def profile_lines(profile: Profile) -> Iterator[str]:
    """Yield the time of each phase, then that of each part of a tick alone."""
    whole = sum(profile.phases.values())
    notes = {"compile": "kept from an earlier run: loaded only" if profile.compiled_before else ""}
    rows = [
        (name, time_text(seconds), f"{100 * seconds / whole:.1f} %", notes.get(name, ""))
        for name, seconds in profile.phases.items()
    ]
    yield from ("", *text_table([("phase", "time", "share", ""), *rows], left=(0, 3)), "")
    alone = sum(part.nanoseconds for part in profile.parts)
    parts = [
        (part.name, f"{part.nanoseconds:.1f}", f"{part.error:.1f}", f"{100 * part.nanoseconds / (alone or 1.0):.1f} %")
        for part in profile.parts
    ]
    head = ("part of a tick", "ns a tick", "±", "share")
    yield from text_table([head, *parts], left=(0,))
    why = ", since a processor overlaps them" if alone > profile.tick else ", its start and end included"
    yield f"each part alone, {alone:.1f} ns together; the loop takes {profile.tick:.1f} ns a tick{why}"
    yield f"timed over {profile.ticks:,} ticks; the clock's own {profile.clock:.1f} ns are taken off each part"
