"""Memory and disk that runs take, from their sizes."""

from collections.abc import Sequence

from rolling.check.run_size import RunSize

SAMPLE_RATE = 48_000  # [Hz], acoustics.wav.SAMPLE_RATE_HZ, which is slow to import
# Bytes of the program.
ALONE = 300e6
PARENT = 110e6  # beside workers
WORKER = 230e6
# Bytes per node of a rough surface and of the window, and per node and sub-cell.
NODE = 16.0
NODE_SUBCELL = 16.0
NODE_MOMENTS = 84.0  # while heights with skewness and kurtosis are made
WINDOW = 20.0
WINDOW_SUBCELL = 700.0
ESTIMATE = 5.0  # nodes of the windows of an error estimate over those of the window
# Bytes of a record while its sound is made, and as long as runs are compared.
STEP = 650.0
SAMPLE = 280.0
TIME_STEP = 300.0  # of a motion
EVENT = 300.0  # recovery event
STEP_COMPARED = 60.0
SAMPLE_COMPARED = 16.0
EVENTS_PER_NODE = 0.6  # approximate recovery events of a node that the contact passes over
# Bytes on disk: of a run, with 5 s of listen.wav, and per step, sample and event of it.
RUN_FILES = 1.7e6
STEP_FILE = 110.0
SAMPLE_FILE = 20.0
CHANNEL_FILE = 12  # of each sample of a channel, in result.h5 and as a WAV
EVENT_FILE = 41.0


def memory(runs: Sequence[RunSize], workers: int) -> dict[str, float]:
    """Estimate the memory [bytes] that runs take in workers, by its largest parts.

    Each worker holds the program, a surface and a window; the sound of one run is made at a time,
    and a part of each record stays until all runs are compared.
    """
    compared = [STEP_COMPARED * run.steps + SAMPLE_COMPARED * _samples(run) for run in runs]
    return {
        "surface": workers * max(_surface_memory(run) for run in runs),
        "window": workers * max(_window_memory(run) for run in runs),
        "record": max(_record_memory(run) for run in runs) + sum(compared) - max(compared),
        "program": ALONE if workers == 1 else PARENT + WORKER * workers,
    }


def _surface_memory(run: RunSize) -> float:
    """Estimate the bytes of the heights of a run, and four times those of its passes."""
    per_node = NODE + NODE_SUBCELL * run.subcells**2
    if run.has_moments:
        per_node += NODE_MOMENTS
    heights = 0.0 if run.is_smooth else per_node * run.surface_nodes
    return heights + 4 * _passes(run)


def _window_memory(run: RunSize) -> float:
    """Estimate the bytes of a window, and of those of an error estimate."""
    nodes = min(run.window_nodes, 2.0 * max(run.n_along, run.n_across)) ** 2
    size = (WINDOW + WINDOW_SUBCELL * run.subcells**2) * nodes
    if run.estimates_error:
        size *= ESTIMATE
    return size


def _record_memory(run: RunSize) -> float:
    """Estimate the memory [bytes] while the sound of a run is made."""
    samples = _samples(run)
    if not run.is_constant:  # the power is oversampled
        samples += samples * 0.25 * run.fastest_m_s / run.step_m / SAMPLE_RATE
    time_steps = 0.0
    if run.has_motion:
        time_steps = run.duration_s * run.motion_rate_hz
    steps = STEP * run.steps + TIME_STEP * time_steps
    return steps + SAMPLE * samples + EVENT * _events(run)


def disk(runs: Sequence[RunSize]) -> float:
    """Estimate the size [bytes] of the files of runs."""
    size = 0.0
    for run in runs:
        size += RUN_FILES + STEP_FILE * run.steps + SAMPLE_FILE * _samples(run)
        size += EVENT_FILE * _events(run) + _passes(run)
        size += CHANNEL_FILE * run.channels * _samples(run)
    return size


def _passes(run: RunSize) -> float:
    """Return the bytes of the passes and the sunk surface of a plate with memory."""
    if not run.kept_passes:
        return 0.0
    return 8.0 * (3 * run.kept_passes * run.solved_steps + run.n_along * run.n_across)


def _samples(run: RunSize) -> float:
    """Return the samples of the sound of a run."""
    return run.duration_s * SAMPLE_RATE


def _events(run: RunSize) -> float:
    """Estimate the number of recovery events of a run, 0 where none are recorded."""
    if not run.keeps_events:
        return 0.0
    across = min(run.smooth_overlap_nodes, run.n_along, run.n_across)
    return EVENTS_PER_NODE * across * run.solved_steps * run.step_nodes
