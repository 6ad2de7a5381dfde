"""The link checker sees what is missing, and is content with what is there."""

from __future__ import annotations

import pytest

from reports.site.links import broken, main

INDEX = (
    '<h1 id="top">x</h1><a href="sub/page.html#there">a</a><a href="#top">b</a><img src="sub/p%20q.png">'
    '<h2 id="größe m">x</h2><a href="#gr%C3%B6%C3%9Fe%20m">d</a>'
)
PAGE = (
    '<p id="there"></p><a href="../index.html">a</a><a href="https://example.org/x">b</a><a href="..">c</a>'
    '<a href="/index.html#top">d</a>'
)


@pytest.fixture
def site(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "index.html").write_text(INDEX)
    (tmp_path / "sub" / "page.html").write_text(PAGE)
    (tmp_path / "sub" / "p q.png").write_bytes(b"")
    return tmp_path


def test_a_whole_site_has_nothing_broken(site):
    assert list(broken(site)) == []
    assert main(site) == 0


@pytest.mark.parametrize(
    ("link", "why"),
    [
        ("gone.html", "leads to no file"),
        ("index.html#gone", "leads to no place 'gone' there"),
        ("#gone", "leads to no place 'gone' there"),
        ("/elsewhere.html", "leads to no file"),
        ("file:///etc/hosts", "has the scheme 'file'"),
        ("https:", "names no host"),
        ("//host/page.html", "has the scheme ''"),
    ],
)
@pytest.mark.parametrize("tag", ['<a href="{}">x</a>', '<img src="{}">'])
def test_what_leads_nowhere_is_named(site, link, why, tag):
    (site / "index.html").write_text(INDEX + tag.format(link))
    (told,) = broken(site)
    assert told.startswith(f"index.html: {link!r} {why}")
    assert main(site) == 1


def test_an_empty_folder_is_no_site(tmp_path):
    assert main(tmp_path) == 1


def test_a_place_is_one_by_its_id_or_its_name(site):
    (site / "index.html").write_text(
        INDEX + '<a name="old"></a><p id="new"></p><a href="#old">x</a><a href="#new">x</a>'
    )
    assert list(broken(site)) == []
