"""The built site loads nothing from the network."""

import re
from pathlib import Path

_LOADED = re.compile(r"""<(?:script|img|iframe|link|source)\b[^>]*?(?:src|href)=["'](?:https?:)?//[^"']*""")
_IMPORTED = re.compile(r"""(?:@import\s+|url\()\s*["']?(?:https?:)?//[^"')]*""")


def outside_addresses(html: Path) -> list[str]:
    """Return what a browser would load from elsewhere: page and tag of each."""
    patterns = {".html": _LOADED, ".css": _IMPORTED}
    return [
        f"{page.relative_to(html)}: {match}"
        for page in sorted(html.rglob("*"))
        if page.suffix in patterns
        for match in patterns[page.suffix].findall(page.read_text(encoding="utf-8"))
    ]
