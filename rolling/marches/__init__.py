"""Pieces of a march, which any number of processes solve, and the results that they make.

The room `contact` knows no notebook, so its error gets the short text of one here, where a person
first meets it.
"""

from rolling.contact.solver import ContactError
from rolling.terminal.notebook import short_traceback

ContactError._render_traceback_ = short_traceback  # type: ignore[attr-defined]
