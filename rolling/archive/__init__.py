"""Archives of arrays: one definition serves their writer, their reader and xarray."""
