"""A scene in SI: its bodies, contact and listener as records of physics, its heights as arrays."""
