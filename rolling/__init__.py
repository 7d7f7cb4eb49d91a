"""Contact noise of a sphere rolling over a rough surface: a scene in, the released elastic energy out."""

__version__ = "0.2.0.dev0"
