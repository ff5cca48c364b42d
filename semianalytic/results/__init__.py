"""What answers are kept in: samples along the interface, whole files, memory asked for."""
