"""Equations as MathML, made at build time.

A page then shows them without a script and without a network.
"""

from __future__ import annotations

import html
import re

from latex2mathml.converter import convert

EQUATION = re.compile(r'<(span|div) class="arithmatex">(.*?)</\1>', re.DOTALL)


def on_page_content(content, page, config, files):
    """Replace the TeX that `pymdownx.arithmatex` marked by MathML."""
    return EQUATION.sub(_mathml, content)


def _mathml(match):
    tag = match.group(1)
    tex = html.unescape(match.group(2)).strip()
    equation = convert(tex[2:-2].strip(), display="block" if tag == "div" else "inline")
    return f'<div class="equation">{equation}</div>' if tag == "div" else equation
