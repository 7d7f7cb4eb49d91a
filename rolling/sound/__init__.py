"""Sound of a run: of the released energy and of the vibration, its receivers, errors and places."""
