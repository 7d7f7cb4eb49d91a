"""Templates of the pages, and their scripts as a single text."""

import re
from types import CodeType

import jinja2
from jinja2.bccache import Bucket
from markupsafe import Markup, escape

from rolling.figures.picture import slug
from rolling.report import text
from rolling.terminal.streams import unbroken

_IMPORT = re.compile(r'^import \{[^}]*\} from "(\./|\.\./)([\w/]+\.js)";\n', re.MULTILINE)


class _CompiledTemplates(jinja2.BytecodeCache):
    """Code of the templates that this process has compiled, for all of its pages."""

    def __init__(self) -> None:
        self._codes = dict[tuple[str, str], CodeType | None]()

    def load_bytecode(self, bucket: Bucket) -> None:
        """Take the code of a template whose text has not changed."""
        bucket.code = self._codes.get((bucket.key, bucket.checksum))

    def dump_bytecode(self, bucket: Bucket) -> None:
        """Keep the code of a template."""
        self._codes[bucket.key, bucket.checksum] = bucket.code


_COMPILED = _CompiledTemplates()


def environment() -> jinja2.Environment:
    """Return the environment of the page, which escapes values and raises on missing values."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("rolling.report", "assets"),
        autoescape=True,
        bytecode_cache=_COMPILED,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "slug": slug,
        "css_text": css_text,
        "coded": coded,
        "unbroken": unbroken,
    }
    # NaN must not reach the script of the page, because it is not JSON.
    environment.policies["json.dumps_kwargs"] = {"allow_nan": False, "separators": (",", ":")}
    return environment


def coded(words: str) -> Markup:
    """Set what stands between backquotes in a sentence as code."""
    return Markup(re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(words))))


def css_text(title: str) -> Markup:
    """Write any text as the inside of a string of CSS, all but letters and digits as numbers."""
    letters = []
    for letter in title:
        if letter.isascii() and letter.isalnum():
            letters.append(letter)
        else:
            letters.append(f"\\{ord(letter):06x}")
    return Markup("".join(letters))


def joined_script(entry: str) -> str:
    """Join a module of `assets/` with all modules that it imports, each once, imports first.

    The modules then share a scope, so no two of them may declare the same name at their top level.
    """
    seen = set[str]()
    parts = list[str]()

    def gather(name: str) -> None:
        """Add the text of a module behind the texts of the modules that it imports."""
        seen.add(name)
        script = text.asset(name)
        room = name.rpartition("/")[0]
        for above, imported in _IMPORT.findall(script):
            path = f"{room}/{imported}" if above == "./" else imported
            if path not in seen:
                gather(path)
        parts.append(re.sub(r"^export ", "", _IMPORT.sub("", script), flags=re.MULTILINE))

    gather(entry)
    return "\n".join(parts)
