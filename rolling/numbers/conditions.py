"""Conditions of an answer: what moved on what, how fast, under which load, and who heard it.

A kind of scene gives them as fields, which files hold as they are. Lines and a paragraph for a
report are made last, here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from rolling import __version__

PROGRAM = "program"


class Condition(NamedTuple):
    """A condition of a scene: its name, such as load, and its value in words.

    leads : bool. Whether the first view of a page has it; all others are in a fold.
    """

    name: str
    words: str
    leads: bool = True


class Method(NamedTuple):
    """How the numbers of a scene are computed.

    motion : str. Sentence on what moves, such as: A sphere rolls over a plate.
    computed : str. Sentences on how the numbers follow from the conditions.
    """

    motion: str
    computed: str


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """Conditions of one scene, or of several that are compared.

    Attributes
    ----------
    by_label : mapping of lists of Condition
        The conditions of each scene, by its label.
    method : Method
        How its numbers are computed.
    """

    by_label: Mapping[str, Sequence[Condition]]
    method: Method

    @property
    def program(self) -> str:
        """Name and version of the program."""
        return f"rolling-contact-noise {__version__}"

    @property
    def shared(self) -> list[Condition]:
        """The conditions that all scenes have."""
        if not self.by_label:
            return []
        first, *others = self.by_label.values()
        return [condition for condition in first if all(condition in other for other in others)]

    @property
    def own(self) -> dict[str, list[Condition]]:
        """The conditions in which scenes differ, by label; empty lists where they have none."""
        shared = self.shared
        return {
            label: [condition for condition in conditions if condition not in shared]
            for label, conditions in self.by_label.items()
        }

    @property
    def lines(self) -> list[str]:
        """The conditions in lines: what all share with the program, and a line for each scene."""
        return [_sentence([*self.shared, Condition(PROGRAM, self.program)]), *self._own_lines]

    @property
    def _own_lines(self) -> list[str]:
        """A line for each scene with conditions of its own."""
        return [
            f"For {label}, {_listed(conditions)}."
            for label, conditions in self.own.items()
            if conditions
        ]

    @property
    def lead(self) -> str:
        """What leads of the conditions that all share, for the first view of a page."""
        words = [condition.words for condition in self.shared if condition.leads]
        return "; ".join(words) or "Conditions"

    def columns(self, label: str) -> dict[str, str]:
        """Return the conditions of a scene for the columns of a table, with the program."""
        values = {condition.name: condition.words for condition in self.by_label[label]}
        return values | {PROGRAM: self.program}

    def paragraph(self, answer: Sequence[str]) -> str:
        """Write the paragraph on methods for a report.

        Parameters
        ----------
        answer : sequence of str
            Sentences on how the answer follows from the numbers, and what nobody has measured.
        """
        sentences = [self.method.motion]
        if self.shared:
            sentences.append(_sentence(self.shared))
        sentences += [*self._own_lines, self.method.computed, *answer]
        sentences.append(f"All of it was computed with {self.program}.")
        return " ".join(sentence for sentence in sentences if sentence)

    def as_json(self) -> dict[str, Any]:
        """Return the conditions for JSON, by label and name."""
        by_label = {
            label: {condition.name: condition.words for condition in conditions}
            for label, conditions in self.by_label.items()
        }
        return {PROGRAM: self.program, "scenes": by_label}


def _sentence(conditions: Sequence[Condition]) -> str:
    """Write conditions as a sentence."""
    words = _listed(conditions)
    return f"{words[0].upper()}{words[1:]}."


def _listed(conditions: Sequence[Condition]) -> str:
    """Write conditions with their names."""
    return "; ".join(f"{condition.name}: {condition.words}" for condition in conditions)
