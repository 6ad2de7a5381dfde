"""Messages of all packages form one list; docstrings, comments and most messages use the words of the field."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from pathlib import Path

import pytest

import mbs_ref
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


def _prose(source: str):
    """Yield every docstring and comment."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            yield ast.get_docstring(node) or ""
    lines = io.StringIO(source).readline
    yield from (token.string for token in tokenize.generate_tokens(lines) if token.type == tokenize.COMMENT)


@pytest.mark.parametrize("package", PACKAGES)
def test_docstrings_and_comments_use_the_words_of_the_field(package):
    files = sorted((Path(mbs_ref.__file__).parents[1] / package).rglob("*.py"))
    vague = [(file.name, text) for file in files for text in _prose(file.read_text()) if VAGUE.search(text)]
    assert files
    assert not [(name, text) for name, text in vague if "type: ignore" not in text]
