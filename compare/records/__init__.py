"""What other codes wrote about an interface: files in, records at stations out."""
