"""Problem sheets with exact answers, and how near a code comes to them."""
