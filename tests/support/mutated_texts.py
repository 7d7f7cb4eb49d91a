"""Texts broken at random: letters, words, values and lines."""

from __future__ import annotations

import random
import re

LETTERS = "[]{}:,-&*?!|>'\"#%@`~<= \n\t\\.0123456789eE+_xnulltrue\u00e9\U0001f600\x00\ufeff\u2028"
WORDS = [
    "0",
    "-1",
    "-0.0",
    "3",
    "64",
    "0.1",
    "1e9",
    "1e-7",
    "1e15",
    "1e-15",
    "1e300",
    "1e-300",
    "1e400",
    "1e-400",
    "5e-324",
    "1.7e308",
    "999999999999999999999999",
    "0x10",
    "0o7",
    "1_000",
    "12:30",
    "2001-01-01",
    ".inf",
    "-.inf",
    ".nan",
    "~",
    "true",
    "no",
    "'20'",
    "''",
    "[]",
    "{}",
    "[1]",
    "{a: 1}",
    "*r",
    "&r",
    "!t",
    "!!python/object:os.system x",
    "|-",
    ">",
    "<<",
    "\u00b5",
    *(
        '"\\ud800"',
        '"\\0"',
        "\u202e5",
        "\ud7ff",
        "\U0001f600",
        "0x" + "f" * 5000,
        "1" * 5000,
        "1e" + "9" * 400,
        "a" * 999,
    ),
    *("[" * 30, "{a: " * 30, "[[0, 1], [1, 0]]", "[[0, 1e-300], [1e300, 0]]", "[1e-15, 1e15]"),
]
LINES = (
    "<<: *r",
    "sweep: {rolling.load_n: [1, 2, 3]}",
    "sweep: {surface.seed: [" + ", ".join(map(str, range(300))) + "]}",
    "sweep: {rolling.load_n: [1, 2], sphere.radius_mm: [1, 2], surface.spacing_um: [1, 2],"
    " rolling.speed_m_s: [1, 2]}",
    "a: &a [1, 1, 1, 1, 1, 1, 1, 1, 1]\nb: &b [*a, *a, *a, *a, *a]\nc: [*b, *b, *b, *b, *b]",
    "m: &m {x: 1}\nn: {<<: [*m, *m]}",
    "rolling: {load_n: 1, speed_m_s: [[0, 1], [1, 1000], [1e6, 0]], duration_s: 1e5}",
    "recovery: {events: true}",
    "sound: {loudness: true, gain_pa_per_w_m2: 1e15}",
    "[a, b]: 1",
    "{a: b}: {c: d}",
    "? [a, {c: d}]\n: 1",
    "? 0x" + "f" * 5000 + "\n: 1",
    "? &k name\n: *k",
    "1: 2",
    "~: 1",
    "true: false",
    "? 2001-01-01\n: 3",
    "---",
    "...",
    "%YAML 1.1",
    "[" * 40,
    "- " * 40,
    "\n".join(" " * k + "a:" for k in range(40)),
    "numerics: {step_nodes: 0.0625, tolerance: 1e-12, edges: sharp, precision: double}",
)
_NUMBER = re.compile(r"(?<=[ \[])[0-9]{1,300}(?:\.[0-9]+)?(?=[],}\n])")
USUAL = ["1", "2", "0.5", "1.5", "64", "10", "0.01", "3e-3", "gaussian", "sharp", "mean", "true"]


def mutated(text: str, chance: random.Random) -> str:
    """Return a text with one to three changes: of a letter, a value, a line or a word."""
    for _ in range(chance.randint(1, 3)):
        at = chance.randrange(len(text) + 1)
        lines = text.split("\n")
        k = chance.randrange(len(lines))
        match chance.randrange(16):
            case 0:
                text = text[:at] + chance.choice(LETTERS) + text[at:]
            case 1:
                text = text[:at] + text[at + chance.randint(1, 12) :]
            case 2 | 3:  # a value
                head, colon, _ = lines[k].partition(": ")
                lines[k] = head + colon + _word(chance)
                text = "\n".join(lines)
            case 4:
                lines.insert(k, chance.choice(LINES))
                text = "\n".join(lines)
            case 5:  # a line elsewhere as well, which may give a key twice
                lines.insert(chance.randrange(len(lines)), " " * chance.randrange(4) + lines[k])
                text = "\n".join(lines)
            case 6:
                del lines[k]
                text = "\n".join(lines)
            case 7:  # a word
                words = text.split(" ")
                words[chance.randrange(len(words))] = _word(chance)
                text = " ".join(words)
            case 8:  # the end is missing
                text = text[:at] if chance.random() < 0.2 else text
            case _:  # a number
                numbers = list(_NUMBER.finditer(text))
                if numbers:
                    span = chance.choice(numbers)
                    other = float(span[0]) * 10.0 ** chance.choice([-9, -3, -1, -0.3, 0.3, 1, 3, 9])
                    text = text[: span.start()] + f"{other:.6g}" + text[span.end() :]
    return text


def _word(chance: random.Random) -> str:
    return chance.choice(USUAL if chance.random() < 0.5 else WORDS)
