"""Commands of the terminal: run a scene, work on stored runs, compare them, look at surfaces."""
