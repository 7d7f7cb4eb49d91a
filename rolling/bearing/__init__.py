"""A ball bearing: geometry, kinematics, static load, and the motion of the ring that vibrates."""
