"""Programs that end with the one that started them, however that ends."""

import ctypes
import os
import signal

PR_SET_PDEATHSIG = 1


def end_with(parent):
    """What this program was writing aside the next one removes. `parent`: the process id of the one that started it."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # it has ended before that
        os._exit(1)
