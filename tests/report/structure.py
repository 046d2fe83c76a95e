"""A page as its elements: what a reader with a keyboard, a screen reader or a phone relies on, without a browser."""

import re
from dataclasses import dataclass, field
from html.parser import HTMLParser

VOID = {"img", "input", "meta", "br"}
ADDRESSES = ("src", "href", "srcset", "action", "poster", "data")


@dataclass
class Element:
    tag: str
    attributes: dict[str, str]
    around: list["Element"]
    """The elements that it stands in, outermost first."""
    text: str = ""

    def inside(self, tag: str, **attributes: str) -> bool:
        return any(each.tag == tag and attributes.items() <= each.attributes.items() for each in self.around)


@dataclass
class Page(HTMLParser):
    """The elements of a page in its order."""

    content: str
    elements: list[Element] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__()
        self._open: list[Element] = []
        self.feed(self.content)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        element = Element(tag, {name: value or "" for name, value in attrs}, list(self._open))
        self.elements.append(element)
        if tag not in VOID:
            self._open.append(element)

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop().tag == tag, f"</{tag}> closes another element"

    def handle_data(self, data: str) -> None:
        for element in self._open:
            element.text += data

    def of(self, *tags: str) -> list[Element]:
        return [each for each in self.elements if each.tag in tags]


def faults(content: str) -> list[str]:
    """What a reader would stumble over; none on a sound page."""
    page = Page(content)
    return [*_tables(page), *_figures(page), *_headings(page), *_links(page), *_scrolled(page)]


def _tables(page: Page) -> list[str]:
    headers = [each for each in page.of("th") if not each.text.strip() or "scope" not in each.attributes]
    return [f"a header of a table without text or scope: {each.text!r}" for each in headers]


def _figures(page: Page) -> list[str]:
    found = [f"a picture without words: {each.attributes}" for each in page.of("img") if not each.attributes.get("alt")]
    moving = [each for each in page.of("img") if each.attributes["src"].startswith("data:image/gif")]
    found += ["a picture that moves by itself" for each in moving if not each.inside("details")]
    found += ["an open animation" for each in page.of("details") if "open" in each.attributes]
    return found + ["a switch without words" for each in page.of("input") if not each.inside("label")]


def _headings(page: Page) -> list[str]:
    levels = [int(each.tag[1]) for each in page.of("h1", "h2", "h3", "h4")]
    found = [f"a heading {high} after {low}" for low, high in zip([0, *levels], levels, strict=False) if high > low + 1]
    return found + [f"{levels.count(1)} headings of the whole page"] * (levels.count(1) != 1)


def _links(page: Page) -> list[str]:
    names = [each.attributes["id"] for each in page.elements if "id" in each.attributes]
    found = [f"a name that stands twice: {name}" for name in {name for name in names if names.count(name) > 1}]
    targets = [each.attributes["href"] for each in page.of("a")]
    found += [f"a link to nowhere: {target}" for target in targets if target.removeprefix("#") not in names]
    sections = [each.attributes.get("id") for each in page.of("section")]
    listed = [each.attributes["href"][1:] for each in page.of("a") if each.inside("nav")]
    found += [f"a section that the contents lack: {name}" for name in sections if name not in listed]
    named = [each.attributes[name] for each in page.elements for name in ADDRESSES if name in each.attributes]
    loads = [address for address in named if not address.startswith(("#", "data:"))]
    loads += [each for style in page.of("style") for each in re.findall(r"url\(|@import", style.text)]
    return found + [f"something is loaded: {each}" for each in loads]


def _scrolled(page: Page) -> list[str]:
    wanted = {"role": "group", "tabindex": "0"}
    boxes = [each for each in page.elements if each.attributes.get("class", "").split()[:1] == ["wide"]]
    bare = [each for each in boxes if not (wanted.items() <= each.attributes.items() and each.attributes["aria-label"])]
    found = [f"no key scrolls it, or it has no name: {each.attributes}" for each in bare]
    tables = [each for each in page.of("table") if not each.inside("div", **wanted)]
    return found + ["a table that widens the page" for _ in tables]
