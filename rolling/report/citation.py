"""Citations of the program and of the article that it follows.

A test compares them with CITATION.cff.
"""

from __future__ import annotations

from rolling import __version__

PROGRAM = f"The rolling-contact-noise authors: rolling-contact-noise (version {__version__}), 2026."
ARTICLE = (
    "Lee, B.; Kim, K.; Kim, T.: Analysis of Contact Noise Due to Elastic Recovery of Surface "
    "Asperities for Spherical "
    "Contact. Inventions 2025, 10(1), 17. doi:10.3390/inventions10010017"
)
