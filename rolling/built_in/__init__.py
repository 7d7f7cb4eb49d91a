"""Kinds of scenes of the program: a ball that rolls or falls on a plate, and a bearing."""
