"""The report page: well-formed, complete, and deaf to markup in what it is given."""

from __future__ import annotations

from html.parser import HTMLParser

from phichain.report.html import Section, page

VOID = {"meta", "img", "br"}


class Balance(HTMLParser):
    """Collects text and pictures, and fails on tags that do not nest."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.text: list[str] = []
        self.images: list[dict[str, str | None]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "img":
            self.images.append(dict(attrs))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text.append(data)


def read(text: str) -> Balance:
    reader = Balance()
    reader.feed(text)
    reader.close()
    assert not reader.open
    return reader


def test_a_page_nests_and_holds_what_it_was_given() -> None:
    sections = [
        Section("First", "Words.", (("energy", "1e-15"),), "motion.png", "The chain in motion"),
        Section("Second"),
    ]
    seen = read(page("Title", "Lead.", sections, "Footer."))
    for words in ("Title", "Lead.", "First", "Words.", "energy", "1e-15", "The chain in motion", "Second", "Footer."):
        assert words in seen.text
    assert seen.images == [{"src": "motion.png", "alt": "The chain in motion"}]


def test_markup_in_the_data_is_shown_not_obeyed() -> None:
    evil = '<script>alert("x")</script>&amp;'
    text = page(evil, evil, [Section(evil, evil, ((evil, evil),), 'a"onerror="b.png', evil)], evil)
    assert "<script" not in text
    seen = read(text)
    assert seen.text.count(evil) == 9
    assert seen.images[0]["src"] == 'a"onerror="b.png'
