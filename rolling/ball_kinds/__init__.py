"""Kinds of scenes with one ball: it rolls over a plate, or falls on it."""
