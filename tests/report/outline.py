"""A page's elements, ids, links and words, and the paths of all fields of a result."""

import json
from html.parser import HTMLParser

VOID = {"meta", "link", "br", "hr", "img", "input"}
OPEN = {"parameters", "versions", "plants", "notes", "torque_correlation"}  #: names below these vary
VARIANTS = {"proportional", "proportional_derivative"}  #: of a damping row


class Outline(HTMLParser):
    """Elements, ids and links of a page; `open` is empty at the end when every element was closed."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.ids, self.targets, self.errors, self.text = [], [], [], [], [], ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self._note(tag, attrs)
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self._note(tag, attrs)

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.errors.append(tag)

    def handle_data(self, data):
        if "style" not in self.open:
            self.text += data

    def _note(self, tag, attrs):
        self.tags.append(tag)
        self.ids += [value for key, value in attrs if key == "id"]
        self.targets += [value for key, value in attrs if key == "href"]


def read_json(text):
    def refuse(constant):
        raise AssertionError(f"{constant} is no JSON")

    return json.loads(text, parse_constant=refuse)


def leaves(value, path=""):
    """Paths of all numbers and words: lists as [], names that vary as *."""
    if isinstance(value, dict):
        for key, item in value.items():
            last = path.rpartition(".")[2]
            ends = set(value) == {"value", "low", "high"}
            varies = ends or last in OPEN or (last == "damping_table[]" and key in VARIANTS)
            yield from leaves(item, f"{path}.{'*' if varies else key}".lstrip("."))
    elif isinstance(value, list):
        for item in value:
            yield from leaves(item, f"{path}[]")
    else:
        yield path
