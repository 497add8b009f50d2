"""Switch pattern: on = slot is even; as a palindrome on = slot mod 4 is 0 or 3, ABBA, blind to drift linear in time.

(Digital quartz accelerometer, section III.B, switches once; patterns that go on are those of
comparison weighings.)
"""

from proofmass.blocks.declaration.declare import Block, Input, param


class SwitchPattern(Block):
    """Pattern of a reference that is switched on and off, slot by slot."""

    palindrome: bool = param("", "Whether it goes on off off on instead of on off on off.", default=False)

    slot = Input("1", "Slot of the measurement, from 0.", dtype=int)
    active = Input("1", "Whether a measurement is under way.", dtype=bool, default=True)


@SwitchPattern.output("1")
def on(p: SwitchPattern, slot: int, active: bool) -> bool:
    """True while the reference is on."""
    return active and ((slot + 1 if p.palindrome else 2 * slot) & 2) == 0
