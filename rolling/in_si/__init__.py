"""A scene in SI: bodies, contact and listener as data classes of physics, heights as arrays."""
