"""Names of bearings: a basic designation, such as 6204, and suffixes, such as -2RS or C3.

Suffixes of seals, shields, cages and tolerance classes change nothing that is computed. Those of a
clearance group set the radial clearance, by the table of ISO 5753-1 and the bore.
"""

import re
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

NORMAL = "CN"  # group of a bearing without a suffix of clearance
_GROUPS = {"C2": "C2", "CN": NORMAL, "C0": NORMAL, "C3": "C3", "C4": "C4", "C5": "C5"}
# Seals and shields of several makers, cages, and tolerance classes of ISO 492.
_WITHOUT_EFFECT = (
    r"2?RS(1|2|R|H|L)?|2?RSL|2?RZ|Z{1,2}R?|2Z(R)?|DDU?|DU|LL[UBH]|L[UBH]|V{1,2}|N|NR|ZN|ZNR|K"
    r"|M|MA|MB|J|TN9?|TNH?|TVH|P[0-6]|P6X|ABEC[13579]|E"
)
_SUFFIX = re.compile(rf"({'|'.join(_GROUPS)}|{_WITHOUT_EFFECT})")
_BETWEEN = re.compile(r"[\s/_.-]+")
EXAMPLES = "-2RS, ZZ, 2Z and C3"


class Designation(NamedTuple):
    """Name of a bearing in its parts.

    basic : str. Basic designation, such as 6204.
    group : str. Clearance group of ISO 5753-1.
    strange : str. First part of the suffixes that is not understood, empty for none.
    """

    basic: str
    group: str
    strange: str


def parsed(name: str, known: Iterable[str]) -> Designation | None:
    """Return the parts of a name that begins with one of some basic designations, None for another.

    A suffix may follow without a sign between, as in 62042RS.
    """
    text = name.strip().upper()
    basics = [basic for basic in known if text.startswith(basic)]
    if not basics:
        return None
    basic = max(basics, key=len)
    group = NORMAL
    for part in _BETWEEN.split(text[len(basic) :]):
        rest = part
        while rest:
            suffix = _longest(rest)
            if not suffix:
                return Designation(basic, group, part)
            group = _GROUPS.get(suffix, group)
            rest = rest[len(suffix) :]
    return Designation(basic, group, "")


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
    """Return the known basic designation that is nearest to a misspelt name, or nothing.

    The last two digits of a bearing are its bore; those before are its series. Letters that look
    like digits are read as these.
    """
    digits = re.match(r"\d*", _as_digits(name))
    given = digits[0] if digits else ""
    series = [other for other in known if other[:-2] == given[:-2]]
    return min(series, key=lambda other: abs(int(other) - int(given)), default="")


def _as_digits(name: str) -> str:
    """Return a name whose letters O, I and L stand for the digits that they look like."""
    return name.strip().upper().translate(str.maketrans("OIL", "011"))
