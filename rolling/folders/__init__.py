"""Folders of this program: how they are made, claimed by one process, replaced, and told from other
people's files.
"""
