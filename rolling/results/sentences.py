"""Sentences of results on terminal, page and in files, from sentences.toml."""

from rolling.check.finding import written
from rolling.scene.messages import table

SENTENCES: dict[str, str] = table("rolling.results", "sentences")


def say(key: str, /, **numbers: object) -> str:
    """Write the sentence of a key with its numbers."""
    return written(SENTENCES[key], **numbers)
