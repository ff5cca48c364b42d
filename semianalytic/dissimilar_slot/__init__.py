"""Two different half-planes with a slot, solved exactly: slip, stick and opening in x/t."""
