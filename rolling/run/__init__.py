"""Runs of scenes: one loop on all cores or on a cluster, and the folders of their files."""
