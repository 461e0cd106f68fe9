"""Numbers put into pages: sentences found by their wording, and blocks between markers."""

import re
from collections.abc import Callable, Iterable, Mapping

from vsb.errors import ConfigError

Value = float | int | str
Values = Mapping[str, Value]
"""By name, SOURCE.NAME."""
FIELD = re.compile(r"\{(?P<sign>-?)(?P<name>[^{}|]+)(?:\|(?P<form>[^{}|]*))?\}")
"""{name|form} in a sentence; {-name|form} is the value with the other sign: "absorbs {-gain|.1f} % less"."""
MINUS = "\N{MINUS SIGN}"
NUMBER = rf"[{MINUS}+-]?\d+(?:\.\d+)?(?:e[{MINUS}+-]?\d+)?"
RESULT = re.compile(rf"{NUMBER}(?:\s+(?:to|and)\s+{NUMBER})*\s*(?:%|points\b|k?W\b|CPU|min\b)")
"""A number that says how much, how certain or how long: of a gain, a power or a computation."""
SOURCED = re.compile(r"<!-- (?:published: \S+|once) -->.*?<!-- end -->|```.*?```|`[^`]*`|\]\([^)]*\)", re.DOTALL)
"""Text whose numbers need no sentence: blocks, what was computed once and says so, code, links."""
BLOCK = re.compile(r"(<!-- published: (?P<name>\S+) -->\n)(?P<text>.*?)(<!-- end -->)", re.DOTALL)


def printed(value: Value, form: str = "", *, negated: bool = False) -> str:
    """Return a value as a sentence prints it.

    Parameters
    ----------
    form : str
        Of Python's format(); `minutes` of seconds, `k.1f` in thousands. A form without a sign is for numbers that are
        not negative: the words around them ("less", "up to") say the direction.

    Examples
    --------
    >>> printed(-5.34, ".1f", negated=True), printed(5.94, "+.1f"), printed(3e-9, ".0e"), printed(150.0, "minutes")
    ('5.3', '+5.9', '3e\u22129', '2')

    Raises
    ------
    ConfigError
        If a number is negative and the form has no sign: the sentence is not true any more.
    """
    if isinstance(value, str):
        return value
    number = -value if negated else value
    if form == "minutes":
        return f"{max(1, round(number / 60))}"
    text = f"{number / 1e3:{form[1:]}}" if form.startswith("k") else f"{number:{form}}"
    if not float(text):
        return text.lstrip("-+")
    if text.startswith("-") and not form.startswith("+"):
        raise ConfigError(f"received {text}, but the words around it give it a direction: the sentence must be changed")
    power_of_ten = re.compile(r"e([+-])0*(?=\d)")
    return power_of_ten.sub(lambda found: f"e{found[1].strip('+')}", text).replace("-", MINUS)


def table(head: list[str], rows: list[list[str]]) -> str:
    """Return a table in Markdown."""
    lines = [f"| {' | '.join(line)} |" for line in (head, *rows)]
    return "\n".join([lines[0], "|---" * len(head) + "|", *lines[1:]])


def completed(sentence: str, values: Values) -> str:
    """Return a sentence with its numbers."""
    return FIELD.sub(lambda field: _printed(field, values), sentence)


def _printed(field: re.Match[str], values: Values) -> str:
    """What stands in place of a field."""
    name = field["name"]
    if name not in values:
        raise ConfigError(f"received {{{name}}}, which no source gives")
    try:
        return printed(values[name], field["form"] or "", negated=bool(field["sign"]))
    except ConfigError as error:
        raise ConfigError(f"{name}: {error}") from error


def place(page: str, sentence: str, values: Values) -> re.Match[str]:
    """Return where a sentence stands on a page; its groups are the numbers.

    Raises
    ------
    ConfigError
        If it does not stand there exactly once: page and sentences.yaml must be changed together.
    """
    fields = list(FIELD.finditer(sentence))
    words = FIELD.split(sentence)[:: 1 + FIELD.groups]
    holes = [rf"({NUMBER})" if not isinstance(values.get(one["name"]), str) else r"(.+?)" for one in fields]
    pattern = "".join(_words(text) + hole for text, hole in zip(words, [*holes, ""], strict=True))
    places = list(re.finditer(pattern, page, re.DOTALL))
    if len(places) != 1:
        raise ConfigError(f"received {len(places)} places of the sentence, needs one: {sentence}")
    return places[0]


def with_sentence(page: str, sentence: str, values: Values) -> str:
    """Return a page with the numbers of a sentence brought up to date."""
    found = place(page, sentence, values)
    text, end = [], 0
    for number, field in enumerate(FIELD.finditer(sentence), 1):
        begin, after = found.span(number)
        text += [page[end:begin], _printed(field, values)]
        end = after
    return "".join(text) + page[end:]


def _words(text: str) -> str:
    """A pattern of words between which a line may end anywhere."""
    return r"\s+".join(re.escape(word) for word in re.split(r"\s+", text))


def with_blocks(page: str, blocks: Mapping[str, Callable[[Values], str]], values: Values) -> str:
    """Return a page with its blocks written anew.

    Raises
    ------
    ConfigError
        If nothing writes a block of that name.
    """

    def block(found: re.Match[str]) -> str:
        name = found["name"]
        if name not in blocks:
            raise ConfigError(f"published: received {name}, needs one of {', '.join(blocks)}")
        return f"{found[1]}\n{blocks[name](values).strip()}\n\n{found[4]}"

    return BLOCK.sub(block, page)


def up_to_date(
    name: str, page: str, sentences: Iterable[str], blocks: Mapping[str, Callable[[Values], str]], values: Values
) -> str:
    """Return a page with all its published numbers."""
    try:
        for sentence in sentences:
            page = with_sentence(page, sentence, values)
        return with_blocks(page, blocks, values)
    except ConfigError as error:
        raise ConfigError(f"{name}: {error}") from error


def unsourced(page: str, sentences: Iterable[str], values: Values) -> list[str]:
    """Return results on a page, with their line, that stand in no block and in no sentence that is listed."""
    spans = [place(page, sentence, values).span() for sentence in sentences]
    spans += [found.span() for found in SOURCED.finditer(page)]
    return [
        f"{page.count(chr(10), 0, found.start()) + 1}: {' '.join(found[0].split())}"
        for found in RESULT.finditer(page)
        if not any(begin <= found.start() < end for begin, end in spans)
    ]
