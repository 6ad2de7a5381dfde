"""The messages of all four packages form one list, and those of the commands and pages use the field's words."""

from __future__ import annotations

import re

import pytest

from tests.messages import PACKAGES, messages

VAGUE = re.compile(r"\b(told|found|asked|made|kept|heard|said|promised|foretold|accused|excused|taught|held against)\b")
PLAIN = ("benchmarks", "reports", "cross_checks/prices")  # packages whose messages have been rewritten


@pytest.mark.parametrize("package", PACKAGES)
def test_every_package_has_messages_with_their_places(package):
    found = messages(package)
    assert found
    assert all(message.file.startswith(package) and message.line > 0 for message in found)


def test_raised_printed_and_help_texts_are_listed():
    texts = {message.text for message in messages("reports")}
    assert "no series in {...} holds {...}" in texts  # raised
    assert "{...} runs added; {...} holds {...}" in texts  # printed
    assert "Run on the workers of a dask cluster." in texts  # help of an option
    assert any(text.startswith("Simulate SCENE and judge the result") for text in texts)  # help of a command


@pytest.mark.parametrize("package", PLAIN)
def test_messages_use_the_words_of_the_field(package):
    assert not [str(message) for message in messages(package) if VAGUE.search(message.text)]
