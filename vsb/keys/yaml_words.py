"""Errors of YAML in plain words: which line, what is wrong there, what to write."""

import re
from typing import NamedTuple

import yaml


class YamlMistake(NamedTuple):
    """A line of a file, from 1, none where it is not known, and what is wrong there."""

    line: int | None
    words: str


_LOOKS_CLOSED = {"[": "]", "{": "}"}


def yaml_mistake(error: Exception, text: str) -> YamlMistake:
    """Return what an error of PyYAML means in a text.

    PyYAML names the place where it could not go on. What is wrong is often a line or two above: a bracket or a
    quotation mark that is still open, a key without its colon.
    """
    if isinstance(error, yaml.reader.ReaderError):
        line = text.count("\n", 0, error.position) + 1
        return YamlMistake(line, f"a character of number {error.character!r} is no text; remove it")
    if not isinstance(error, yaml.MarkedYAMLError) or error.problem_mark is None:
        return YamlMistake(None, " ".join(str(error).split()))
    place = _Place(error, error.problem_mark, text.splitlines())
    for meaning in (_tab, _bracket, _quotation, _first_character, _document, _colon, _indentation):
        if found := meaning(place):
            return found
    said = [(error.problem, error.problem_mark), (error.context, error.context_mark)]
    words = [f"{part}, line {mark.line + 1}, column {mark.column + 1}" for part, mark in said if part and mark]
    return YamlMistake(error.problem_mark.line + 1, " ".join(", ".join(words).split()))


class _Place:
    """Where PyYAML could not go on, and why; lines and columns from 0, as its own."""

    def __init__(self, error: yaml.MarkedYAMLError, mark: yaml.Mark, lines: list[str]) -> None:
        self.problem, self.context = error.problem or "", error.context or ""
        self.line, self.column = mark.line, mark.column
        self.begun = error.context_mark.line if error.context_mark else mark.line
        self.begun_at = error.context_mark.column if error.context_mark else 0
        self.lines = lines

    def text(self, line: int) -> str:
        """A line; empty beyond the end."""
        return self.lines[line] if 0 <= line < len(self.lines) else ""

    @property
    def before(self) -> int:
        """The last line above that says something."""
        said = (i for i in range(min(self.line, len(self.lines)) - 1, -1, -1) if _said(self.lines[i]))
        return next(said, self.line)


def _said(line: str) -> str:
    """A line without comment and blanks."""
    return re.sub(r"(^|\s)#.*", "", line).strip()


def _indent(line: str) -> int:
    """Blanks a line begins with."""
    return len(line) - len(line.lstrip())


def _tab(at: _Place) -> YamlMistake | None:
    """A tab where only spaces may stand."""
    if "'\\t'" not in at.problem:
        return None
    return YamlMistake(at.line + 1, f"a tab stands in column {at.column + 1}; write spaces there")


def _bracket(at: _Place) -> YamlMistake | None:
    """A bracket that is not closed, closed by another, or closes none; commas missing or too many between brackets."""
    if found := re.fullmatch(r"expected <block end>, but found '([\]}])'", at.problem):
        return YamlMistake(at.line + 1, f"the bracket {found[1]} closes none that is open")
    if not at.context.startswith("while parsing a flow"):
        return None
    got = at.problem.partition("got ")[2].strip("'")
    if at.context.endswith("node"):
        return YamlMistake(at.line + 1, f"a value is missing before column {at.column + 1}")
    opened = at.text(at.begun)[at.begun_at : at.begun_at + 1]
    if got in _LOOKS_CLOSED.values():
        return YamlMistake(at.line + 1, f"the bracket {opened} of line {at.begun + 1} is closed by {got}")
    if at.line == at.begun and got != "<stream end>":
        return YamlMistake(at.line + 1, f"a comma is missing between two values, before column {at.column + 1}")
    return YamlMistake(at.begun + 1, f"the bracket {opened} in column {at.begun_at + 1} is not closed")


def _quotation(at: _Place) -> YamlMistake | None:
    """A quotation mark that is not closed, or a backslash between two."""
    if "quoted scalar" not in at.context:
        return None
    if "escape" in at.problem:
        return YamlMistake(at.line + 1, "a backslash in double quotation marks begins an escape; write single ones")
    mark = at.text(at.begun)[at.begun_at : at.begun_at + 1]
    return YamlMistake(at.begun + 1, f"the quotation mark {mark} in column {at.begun_at + 1} is not closed")


def _first_character(at: _Place) -> YamlMistake | None:
    """A text that begins with a character which means something else to YAML."""
    found = re.fullmatch(r"found character '(.)' that cannot start any token", at.problem)
    if not found and not re.fullmatch("while scanning an (alias|anchor)", at.context):
        return None
    character = found[1] if found else at.text(at.begun)[at.begun_at : at.begun_at + 1]
    return YamlMistake(at.line + 1, f"a text cannot begin with {character}; put it in quotation marks")


def _document(at: _Place) -> YamlMistake | None:
    """A second document."""
    if "another document" not in at.problem:
        return None
    return YamlMistake(at.line + 1, "--- begins a second document; needs one in a file")


def _colon(at: _Place) -> YamlMistake | None:
    """A key without colon, or without a space behind it; a second colon in a line."""
    if "could not find expected ':'" in at.problem:
        return YamlMistake(at.begun + 1, _without_colon(at.text(at.begun)))
    two = "mapping values are not allowed" in at.problem
    if two and re.search(r":\s", at.text(at.line)[: at.column]):
        return YamlMistake(
            at.line + 1, "two colons in one line: put a text with a colon in quotation marks, a section in lines below"
        )
    above = _said(at.text(at.before))
    if (two or "<block mapping start>" in at.problem) and not re.search(r":(\s|$)", above):
        return YamlMistake(at.before + 1, _without_colon(above))
    return None


def _without_colon(line: str) -> str:
    """What a line lacks that should be a key and its value."""
    word = re.split(r"[\s:=]", _said(line), maxsplit=1)[0]
    lacks = "a space is missing behind the colon" if ":" in line else "a colon is missing behind the key"
    return f"{lacks}; write {word}: and its value"


def _indentation(at: _Place) -> YamlMistake | None:
    """Keys of one section, or items of one list, that do not begin in one column."""
    starts = ("<block mapping start>", "<block sequence start>", "but found '-'", "mapping values are not allowed")
    if not any(start in at.problem for start in starts):
        return None
    here, above = _indent(at.text(at.line)), _indent(at.text(at.before))
    if here == above:
        return YamlMistake(at.line + 1, "a list item, with a dash, stands among keys; needs one or the other")
    return YamlMistake(
        at.line + 1,
        f"indented by {here} space{'s' * (here != 1)}, the line above by {above}; keys of one section begin in one "
        "column, and so do the items of a list",
    )
