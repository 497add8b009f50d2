"""One Chromium for all tests of live pages."""

from collections.abc import Iterator
from typing import Any

import pytest

from tests.by_hand.chromium import CHROMIUM, FLAGS


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    # start-up time: where there is no Playwright, the tests are skipped before they ask for it
    from playwright.sync_api import sync_playwright

    with sync_playwright() as made:
        browser = made.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield browser
        browser.close()
