"""Names of bearings: a basic designation, such as 6204, and suffixes, such as -2RS or C3.

Suffixes of seals, shields, cages, greases and tolerance classes change nothing that is computed.
Those of a clearance group set the radial clearance, by the table of ISO 5753-1 and the bore.
"""

import re
import unicodedata
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

NORMAL = "CN"  # group of a bearing without a suffix of clearance
_GROUPS = {"C2": "C2", "CN": NORMAL, "C0": NORMAL, "C3": "C3", "C4": "C4", "C5": "C5"}
# Seals and shields of several makers, cages, tolerance classes of ISO 492, and fillings of grease
# as SKF (WT, GJN, MT33), FAG (L038), NTN (2AS) and NSK (SRL) write them.
_WITHOUT_EFFECT = (
    r"2?RS(1|2|R|H|L)?|2?RSL|2?RZ|Z{1,2}R?|2Z(R)?|DDU?|DU|LL[UBH]|L[UBH]|V{1,2}|N|NR|ZN|ZNR|K"
    r"|M|MA|MB|J|TN9?|TNH?|TVH|P[0-6]|P6X|ABEC[13579]|E"
    r"|WT|GJN|MT33|MT47|LT|LHT23|HT|GE2|VL0\d{3}|L\d{3}|2AS|5K|SRL|NS7S?|AS2S?"
)
_SUFFIX = re.compile(rf"({'|'.join(_GROUPS)}|{_WITHOUT_EFFECT})")
_DASHES = re.compile("[\u2010-\u2015\u2212]")  # hyphens and dashes of text programs, and a minus
_BETWEEN = re.compile(r"[\s/_.-]+")
EXAMPLES = "-2RS, ZZ, 2Z and C3"


class Designation(NamedTuple):
    """Name of a bearing in its parts.

    basic : str. Basic designation, such as 6204.
    group : str. Clearance group of ISO 5753-1.
    strange : str. Suffixes from the first one that is not understood to the next sign between them,
        empty for none.
    groups : tuple of str. All clearance groups of the name, of which there is one at most.
    """

    basic: str
    group: str
    strange: str
    groups: tuple[str, ...] = ()

    @property
    def is_understood(self) -> bool:
        """Whether all suffixes are known, and state one clearance."""
        return not self.strange and len(self.groups) <= 1


def parsed(name: str, known: Iterable[str]) -> Designation | None:
    """Return the parts of a name that begins with one of some basic designations, None for another.

    A suffix may follow without a sign between, as in 62042RS.
    """
    text = _plain(name)
    basics = [basic for basic in known if text.startswith(basic)]
    if not basics:
        return None
    basic = max(basics, key=len)
    parts = _BETWEEN.split(text[len(basic) :])
    groups = dict[str, None]()  # in their order
    for part in parts:
        rest = part
        while rest:
            suffix = _longest(rest)
            if not suffix and parts[0].isdigit():  # 63004 is another bearing, not 6300
                return None
            if not suffix:
                return Designation(basic, NORMAL, rest)
            if suffix in _GROUPS:
                groups[_GROUPS[suffix]] = None
            rest = rest[len(suffix) :]
    return Designation(basic, next(iter(groups), NORMAL), "", tuple(groups))


def _longest(text: str) -> str:
    """Return the longest known suffix at the beginning of a text, after which others may follow."""
    for end in range(len(text), 0, -1):
        if _SUFFIX.fullmatch(text[:end]):
            return text[:end]
    return ""


def clearance_um(bore_mm: float, group: str, table: Mapping[Any, Mapping[str, Any]]) -> float:
    """Return the middle of the radial clearance [um] of a group for a bore.

    Parameters
    ----------
    bore_mm : float, mm
        Bore, up to the largest of the table.
    group : str
        Clearance group.
    table : dict
        Least and largest clearance [um] by group, by the largest bore [mm] for which they hold.
    """
    for largest_mm in sorted(table):
        if bore_mm <= largest_mm:
            least, most = table[largest_mm][group]
            return float(least + most) / 2
    raise ValueError(f"no clearance of ISO 5753-1 for a bore of {bore_mm:g} mm")


def nearest_basic(name: str, known: Iterable[str]) -> str:
    """Return the known basic designation that is nearest in size to a name, or nothing.

    Bores are compared first, then diameter series. Letters that look like digits are read as these.
    """
    size = _size(_digits(name))
    if size is None:
        return ""
    known_sizes = {basic: known_size for basic in known if (known_size := _size(basic))}
    return min(
        known_sizes,
        key=lambda basic: (
            abs(known_sizes[basic].bore_mm - size.bore_mm),
            abs(known_sizes[basic].series - size.series),
        ),
        default="",
    )


def prefix_of(name: str) -> str:
    """Return the letters before the digits of a name, such as W of W6204; empty without some."""
    text = _plain(name)
    letters = re.match(r"[^\d]*", text)
    has_digits = re.search(r"\d", text) is not None
    return letters[0].strip(" -") if letters and has_digits else ""


class _BoreAndSeries(NamedTuple):
    """Size that a basic designation states: bore [mm], and diameter series, 8 and 9 below 0."""

    bore_mm: int
    series: int


_SMALL_BORES = {0: 10, 1: 12, 2: 15, 3: 17}  # mm, by their codes; larger ones have 5 mm a code


def _size(digits: str) -> _BoreAndSeries | None:
    """Return the size of the digits of a basic designation, None of too few or too many.

    The last two are the code of the bore, and the one before is the diameter series. Of three
    digits that begin with 6 the last one is the bore.
    """
    if not 3 <= len(digits) <= 5:
        return None
    if len(digits) == 3 and digits[0] == "6":
        return _BoreAndSeries(int(digits[2]), _series(digits[1]))
    code = int(digits[-2:])
    return _BoreAndSeries(_SMALL_BORES.get(code, 5 * code), _series(digits[-3]))


def _series(digit: str) -> int:
    """Return a diameter series in the order of outside diameters: 8 and 9 are below 0."""
    return int(digit) - 10 if digit in "89" else int(digit)


def _digits(name: str) -> str:
    """Return the first digits of a name; letters O, I and L stand for those that they look like."""
    text = _plain(name)
    beginning = text[len(prefix_of(name)) :].lstrip(" -")
    digits = re.match(r"\d*", beginning.translate(str.maketrans("OIL", "011")))
    return digits[0] if digits else ""


def _plain(name: str) -> str:
    """Return a name in capital letters, with plain digits, spaces and hyphens."""
    return _DASHES.sub("-", unicodedata.normalize("NFKC", name)).strip().upper()
