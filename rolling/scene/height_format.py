"""What all files of heights share: units, the limit of their size, and the reason of a refusal."""

UNITS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}  # of heights, in m
MAX_BYTES = 500_000_000  # of a file, packed or not; reading takes long, and .npy may be larger


class HeightFormatError(Exception):
    """A reason why a file cannot be read as heights, with the line of a text file that has it."""

    def __init__(self, message: str, line: int | None = None) -> None:
        super().__init__(message)
        self.line = line

    def of(self, name: object) -> str:
        """Write the reason behind the name of the file and the line."""
        return f"{name}: {self}" if self.line is None else f"{name}:{self.line}: {self}"
