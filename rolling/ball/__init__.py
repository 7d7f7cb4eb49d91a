"""Ball on a plate: the kind of scene that turns its sections into the records of physics."""
