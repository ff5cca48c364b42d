"""Tables of text with headings and units, whoever wrote them."""
