"""Ball and plate that vibrate on a rough contact: force law, bodies, and motion in time."""
