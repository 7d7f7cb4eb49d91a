"""Sound of a run: from the energy released along the track to the sound pressure in time."""
