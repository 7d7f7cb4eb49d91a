"""Contacts of a bearing with its surfaces: scenes that are marched, and the tracks they become."""
