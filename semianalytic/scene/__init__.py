"""What is asked: bodies, tractions and histories, friction laws; read, checked, refused."""
