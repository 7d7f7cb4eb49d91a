"""Recordings of the real thing beside runs: records, their pairs, levels and differences."""
