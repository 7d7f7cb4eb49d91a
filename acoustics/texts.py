"""Texts of strangers, from files and names of files, as lists and tables may have them."""


def printable(text: str) -> str:
    r"""Escape control characters, directions of writing and bytes that are not UTF-8.

    A line feed becomes \n, the byte 255 in the name of a file \xff.

    >>> printable("red: \x1b[31m")
    'red: \\x1b[31m'
    """
    if text.isprintable():
        return text
    return "".join(letter if letter.isprintable() else _escaped(letter) for letter in text)


def cell(text: str) -> str:
    """Return a text for a cell of a CSV file, which no spreadsheet takes for a formula.

    A text that begins as a formula does, and is no number, gets an apostrophe, which spreadsheets
    take for the mark of a text. Control characters are escaped.

    >>> cell("=HYPERLINK(1)"), cell("-5"), cell("load 5 N")
    ("'=HYPERLINK(1)", '-5', 'load 5 N')
    """
    is_formula = text.startswith(_FORMULA) and not _is_number(text)
    return f"'{printable(text)}" if is_formula else printable(text)


_FORMULA = tuple("=+-@\t\r")


def _is_number(text: str) -> bool:
    """Return whether a text is a number, such as -5 or +1e3."""
    try:
        float(text)
    except ValueError:
        return False
    return text == text.strip()


def _escaped(letter: str) -> str:
    if 0xDC80 <= ord(letter) <= 0xDCFF:  # Python's surrogate for a byte that is not UTF-8
        return f"\\x{ord(letter) - 0xDC00:02x}"
    return letter.encode("unicode_escape").decode("ascii")
