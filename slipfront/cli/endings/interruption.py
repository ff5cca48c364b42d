"""Exit codes and message of interrupted commands."""

INTERRUPTED = 130
TERMINATED = 143
INTERRUPTION = "Interrupted; files not yet complete were not written."
