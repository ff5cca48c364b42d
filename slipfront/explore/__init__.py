"""A page in the browser on which everything is drawn anew while a slider moves; needs bokeh.

Scene to values of controls and back (`controls`), what is drawn of an answer (`views`) and the map
of regimes around it (`maps`), both plain arrays; what takes seconds in a process of its own
(`work`); pictures that are sent anew (`pictures`); files to take home (`downloads`); the page and
what it answers (`page`); the server on this machine alone (`serving`), and how quick it is, as
measured in a browser (`latency`, `chromium`).
"""
