"""Folders of this program: they are made, claimed by one process, replaced and recognized."""
