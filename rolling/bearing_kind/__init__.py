"""Bearings that turn: contacts, motion of the ring, sound of the housing, and what is shown."""
