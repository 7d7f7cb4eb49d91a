"""Records in files: one definition of their arrays serves writer, reader and xarray."""
