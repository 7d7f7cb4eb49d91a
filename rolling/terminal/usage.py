"""Usage errors that name the nearest command or option."""

from __future__ import annotations

import argparse
import difflib
import re
from collections.abc import Sequence
from typing import NoReturn

_ALIKE = 0.5  # least likeness of a nearest name, between 0 and 1


def refuse_unknown_command(
    parser: argparse.ArgumentParser, words: Sequence[str], commands: Sequence[str]
) -> None:
    """Exit with a usage error if the first word that is no option is no command."""
    name = next((word for word in words if not word.startswith("-")), None)
    if name is not None and name not in commands:
        near = _nearest(name, commands)
        parser.error(f"COMMAND: got {name}{near}, allowed: {', '.join(commands)}")


def refuse_unknown_arguments(parser: argparse.ArgumentParser, unknown: Sequence[str]) -> NoReturn:
    """Exit with a usage error about arguments that a command does not take."""
    options = sorted(set(re.findall(r"--[a-z][a-z-]*", parser.format_help())))
    slips = [word.partition("=")[0] for word in unknown if word.startswith("--")]
    near = next(filter(None, (_nearest(slip, options) for slip in slips)), "")
    parser.error(f"got {' '.join(unknown)}{near}, allowed: {', '.join(options)}")


def _nearest(name: str, names: Sequence[str]) -> str:
    """Write ", nearest: name" with the name that is like a misspelt one, or nothing."""
    near = difflib.get_close_matches(name.lower(), names, 1, _ALIKE)
    return f", nearest: {near[0]}" if near else ""
