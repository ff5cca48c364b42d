"""How an interrupted command ends: its exit codes, and the one line it says."""

INTERRUPTED = 130
TERMINATED = 143
INTERRUPTION = "Interrupted; files not yet complete were not written."
