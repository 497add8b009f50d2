"""The system's Chromium, alone and offline; pages in it, and `proofmass live` beside it."""

import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--allow-file-access-from-files",
    "--enable-logging=stderr",
    "--log-level=0",
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
]
SMALLEST_TEXT = """() => [...document.querySelectorAll('body *')].filter(one => one.getClientRects().length
    && !one.closest('script, style, title, defs')
    && [...one.childNodes].some(node => node.nodeType === 3 && node.textContent.trim())
).map(one => {
    const scale = one.ownerSVGElement ? one.getScreenCTM() : { a: 1, b: 0 };
    return [parseFloat(getComputedStyle(one).fontSize) * Math.hypot(scale.a, scale.b), one.textContent];
}).reduce((least, one) => one[0] < least[0] ? one : least)"""  # height in pixels of the screen, and the text

BROKEN_WORDS = """() => [...document.querySelectorAll('.parameter label, .parameter > span, summary, .measures th')]
.flatMap(one => [...one.childNodes].filter(node => node.nodeType === 3 && node.textContent.trim()).filter(node => {
    const range = document.createRange(), box = one.getBoundingClientRect();
    range.selectNodeContents(node);
    const lines = new Set([...range.getClientRects()].map(line => Math.round(line.top)));
    return !node.textContent.includes(' ') && lines.size > 1 || range.getBoundingClientRect().right > box.right + 0.6;
}).map(node => node.textContent))"""  # what a line ends within, or what leaves its place


def opened(browser: Any, address: str, **options: Any) -> tuple[Any, list[str]]:
    """A page, and the lines of its console and its requests to elsewhere."""
    context = browser.new_context(viewport={"width": 1400, "height": 900}, **options)
    page, lines = context.new_page(), list[str]()
    own = urlsplit(address)
    page.on("console", lambda message: lines.append(message.text))
    page.on("pageerror", lambda error: lines.append(str(error)))
    page.on("request", lambda request: lines.append(request.url) if _is_foreign(request.url, own.netloc) else None)
    page.goto(address)
    return page, lines


def _is_foreign(url: str, host: str) -> bool:
    parts = urlsplit(url)
    return parts.scheme not in ("file", "blob") and parts.netloc != host


def digest(page: Any, other_than: str = "") -> str:
    """The hash of the traces, when there is another one than before."""
    wanted = (
        "old => { const text = document.querySelector('.bits')?.textContent; return text && text !== old && text; }"
    )
    shown = page.wait_for_function(wanted, arg=other_than, timeout=15_000).json_value()
    return str(shown)


def hash_of(shown: str) -> str:
    return shown.removeprefix("SHA-256 of the traces: ")


class Process:
    """`proofmass live` of a file, as a process of its own."""

    def __init__(self, file: Path, *options: str) -> None:
        words = [sys.executable, "-m", "proofmass", "live", str(file), "--no-browser", *options]
        environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
        self.process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=environment)
        assert self.process.stdout is not None
        for line in self.process.stdout:
            if address := re.search(r"http://\S+", line):
                self.url = address[0]
                return
        raise AssertionError("it ended before it was ready")

    def kill(self) -> None:
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGKILL)
            self.process.communicate()
