"""Build the documentation site: `python -m docs.site`, or `make docs`.

The pages are staged in build/site/source and built into build/site/html. A warning ends the build.
"""

import subprocess
import sys

from docs.site.offline import outside_addresses
from docs.site.stage import ROOT, stage


def main() -> int:
    source, html = ROOT / "build" / "site" / "source", ROOT / "build" / "site" / "html"
    pages = stage(source, runs=True)
    doctrees = ROOT / "build" / "site" / "doctrees"
    words = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-j", "2", "-b", "html"]
    status = subprocess.call([*words, "-d", str(doctrees), str(source), str(html)], cwd=ROOT)
    if status:
        return status
    loaded = outside_addresses(html)
    for line in loaded:
        print(line, file=sys.stderr)
    if not loaded:
        print(f"{len(pages)} pages: {html.relative_to(ROOT)}/index.html")
    return 1 if loaded else 0


if __name__ == "__main__":
    sys.exit(main())
